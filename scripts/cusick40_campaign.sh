#!/bin/sh
# Builds a campaign folder over a copy of the forty Cusick silhouettes, ready for `hemline run`.
#
#   scripts/cusick40_campaign.sh SOURCE TARGET
#
# SOURCE holds design.csv and silhouettes/*.jpg (the Cusick Drape Dataset of Gong, Mao & Wang, CVPR 2024, arranged as a 2³ × 5 factorial).
# TARGET must not exist yet. The data set states no licence: neither the pictures nor numbers traced from them belong into a repository.
set -eu

if [ $# -ne 2 ]; then
    echo "usage: $0 SOURCE TARGET" >&2
    exit 2
fi
source=$1
target=$2
if [ ! -f "$source/design.csv" ] || [ ! -d "$source/silhouettes" ]; then
    echo "$source: design.csv and silhouettes/ are needed there" >&2
    exit 2
fi
if [ -e "$target" ]; then
    echo "$target: exists already; name a new folder" >&2
    exit 2
fi

mkdir -p "$target/silhouettes"
cp "$source/design.csv" "$target/"
cp "$source"/silhouettes/*.jpg "$target/silhouettes/"
chmod -R u+w "$target"
cat > "$target/campaign.toml" <<'TOML'
title = "Forty Cusick silhouettes: fabric against two negative controls"
origin = "Cusick Drape Dataset (D. Gong, N. Mao, H. Wang, CVPR 2024): real fabrics on a Cusick drape tester; arranged here as a 2³ × 5 factorial"
apparatus = "drapemeter"

[geometry]
support_radius_cm = 9.0
specimen_radius_cm = 15.0

# No [cloth]: areal density and rigidity are not published with the pictures.

[[factors]]
name = "fabric"
label = "fabric (−1: Fabric 5, stiff; +1: Fabric 3, soft)"
low = -1
high = 1

[[factors]]
name = "capture"
label = "draping of the same sample (−1: first; +1: fourth), a negative control"
low = -1
high = 1

[[factors]]
name = "batch"
label = "samples (−1: 1–5; +1: 7–11), a negative control"
low = -1
high = 1

# Without areal density λ is known only per weight of cloth.
[analysis]
responses = ["p", "q", "s", "m", "lambda_over_weight", "rms", "fold_depth", "explained", "drape_coefficient"]

[profiles]
scale_mm_per_px = 1.383
object = "dark"
TOML
echo "$target: $(ls "$target/silhouettes" | wc -l) silhouettes; analyse with: hemline run $target --out REPORT"
