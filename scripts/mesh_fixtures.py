"""Meshes of known surfaces, written by independent libraries: what tests/import_meshes.rs reads.

Surface (MODEL, section 2): c(t) = (p + q cos mt) e_r + s sin 2mt e_θ with p, q, s linear in height; p(z) = 0.20 - 0.15 z,
q(z) = 0.040 - 0.12 z, s(z) = 0.006 - 0.018 z (m; z = height above the hem), m = 6, 0 <= z <= 0.25; crest at 0.3 rad, axis at (0.01, -0.02).
Writers: trimesh 4 (OBJ, PLY text and binary, STL binary and text, GLB, glTF), meshio 5 (PLY big-endian), numpy-stl (STL).

    /root/venv/bin/pip install trimesh meshio numpy-stl && /root/venv/bin/python scripts/mesh_fixtures.py tests/files/meshes
"""
import sys
from pathlib import Path

import meshio
import numpy as np
import trimesh
from stl import mesh as numpy_stl

out = Path(sys.argv[1])
out.mkdir(parents=True, exist_ok=True)

M, N, ROWS, HEIGHT = 6, 60, 6, 0.25


def surface(z, t):
    p, q, s = 0.20 - 0.15 * z, 0.040 - 0.12 * z, 0.006 - 0.018 * z
    rho, tau = p + q * np.cos(M * t), s * np.sin(2 * M * t)
    a = t + 0.3
    return np.c_[0.01 + rho * np.cos(a) - tau * np.sin(a), -0.02 + rho * np.sin(a) + tau * np.cos(a), z]


rows = np.linspace(0, HEIGHT, ROWS)
V = np.vstack([surface(np.full(N, z), 2 * np.pi * (np.arange(N) + 0.5 * (i % 2)) / N) for i, z in enumerate(rows)])
quads = np.array([[i * N + j, i * N + (j + 1) % N, (i + 1) * N + (j + 1) % N, (i + 1) * N + j] for i in range(ROWS - 1) for j in range(N)])
F = np.vstack([quads[:, [0, 1, 2]], quads[:, [0, 2, 3]]])
mm = trimesh.Trimesh(V * 1000, F, process=False)

# Millimetres, z up.
mm.export(out / "skirt_mm.obj", include_normals=False, digits=4)
(out / "skirt_ascii_mm.ply").write_bytes(trimesh.exchange.ply.export_ply(mm, encoding="ascii"))
(out / "skirt_little_mm.ply").write_bytes(trimesh.exchange.ply.export_ply(mm, encoding="binary"))
(out / "skirt_mm.stl").write_bytes(trimesh.exchange.stl.export_stl(mm))
# Quads, centimetres, y up (x → z → y cyclic): as a modelling program leaves them.
with open(out / "quads_cm_y_up.obj", "w") as f:
    f.write("# quads, y up\no cloth\n")
    f.writelines("v %.5f %.5f %.5f\n" % (100 * y, 100 * z, 100 * x) for x, y, z in V)
    f.writelines("f %d//%d %d//%d %d//%d %d//%d\n" % tuple(np.repeat(q - len(V), 2)) for q in quads)
    f.writelines("vn 0 0 1\n" for _ in V)
text = Path(out / "quads_cm_y_up.obj").read_text().splitlines(keepends=True)
faces = [line for line in text if line.startswith("f ")]
(out / "quads_cm_y_up.obj").write_text("".join([line for line in text if not line.startswith("f ")] + faces))
# glTF: metres, y up, vertices split as at texture seams.
metres = trimesh.Trimesh(np.c_[V[:, 1], V[:, 2], V[:, 0]], F, process=False)
(out / "skirt.glb").write_bytes(trimesh.exchange.gltf.export_glb(trimesh.Scene(metres), include_normals=False))
import base64, json

files = trimesh.exchange.gltf.export_gltf(trimesh.Scene(metres), include_normals=False, merge_buffers=True)
tree = json.loads(files["model.gltf"])
(buffer,) = tree["buffers"]
external = dict(tree, buffers=[dict(buffer)])
(out / "external.gltf").write_text(json.dumps(external))
buffer["uri"] = "data:application/octet-stream;base64," + base64.b64encode(files[buffer["uri"]]).decode()
(out / "skirt.gltf").write_text(json.dumps(tree))

# Coarser, to stay small: text STL in metres upside down, big-endian PLY with 64-bit numbers, numpy-stl's own header.
n, few = 36, 3
rows = np.linspace(0, HEIGHT, few)
W = np.vstack([surface(np.full(n, z), 2 * np.pi * np.arange(n) / n) for z in rows])
quads = np.array([[i * n + j, i * n + (j + 1) % n, (i + 1) * n + (j + 1) % n, (i + 1) * n + j] for i in range(few - 1) for j in range(n)])
G = np.vstack([quads[:, [0, 1, 2]], quads[:, [0, 2, 3]]])
down = trimesh.Trimesh(W * [1, -1, -1], G, process=False)
(out / "coarse_down_m_ascii.stl").write_text("\n".join(" ".join("%.7g" % float(w) if w[-1].isdigit() else w for w in line.split()) for line in trimesh.exchange.stl.export_stl_ascii(down).splitlines()) + "\n")
meshio.write_points_cells(out / "coarse_big_cm.ply", W * 100, [("quad", quads)], binary=True)
raw = (out / "coarse_big_cm.ply").read_bytes()
if b"little_endian" in raw[:200]:
    header, body = raw.split(b"end_header\n", 1)
    size = 8 * 3 * len(W)
    floats = np.frombuffer(body[:size], "<f8").astype(">f8").tobytes()
    rest, faces = body[size:], b""
    count, index = header.split(b"property list ")[1].split()[:2]
    kinds = {b"uint8": "u1", b"uchar": "u1", b"int32": "i4", b"int": "i4", b"int64": "i8", b"uint32": "u4", b"uint": "u4"}
    c, k = np.dtype(kinds[count]), np.dtype(kinds[index])
    row = np.dtype([("n", c.newbyteorder("<")), ("v", k.newbyteorder("<"), 4)])
    table = np.frombuffer(rest, row)
    big = np.empty(len(table), np.dtype([("n", c.newbyteorder(">")), ("v", k.newbyteorder(">"), 4)]))
    big["n"], big["v"] = table["n"], table["v"]
    (out / "coarse_big_cm.ply").write_bytes(header.replace(b"little", b"big") + b"end_header\n" + floats + big.tobytes())
own = numpy_stl.Mesh(np.zeros(len(G), dtype=numpy_stl.Mesh.dtype))
own.vectors = (W * 1000)[G]
own.save(str(out / "coarse_mm_numpy.stl"))
# A hole in the cloth, and a body of smaller radius inside, closed above and below; a lining under the cloth.
keep = [f for f in G if not (n + 3 <= f.min() < n + 4)]
# Below the hem's level nothing: the body ends 2 cm above it.
body_rows = np.linspace(0.02, HEIGHT, 4)
B = np.vstack([np.c_[0.01 + 0.09 * np.cos(a := 2 * np.pi * np.arange(24) / 24), -0.02 + 0.09 * np.sin(a), np.full(24, z)] for z in body_rows])
bq = np.array([[i * 24 + j, i * 24 + (j + 1) % 24, (i + 1) * 24 + (j + 1) % 24, (i + 1) * 24 + j] for i in range(3) for j in range(24)])
with open(out / "hole_and_body_mm.obj", "w") as f:
    f.write("o cloth\n")
    f.writelines("v %.4f %.4f %.4f\n" % tuple(1000 * v) for v in W)
    f.writelines("f %d %d %d\n" % tuple(t + 1) for t in keep)
    f.write("o body\n")
    f.writelines("v %.4f %.4f %.4f\n" % tuple(1000 * v) for v in B)
    f.writelines("f %d %d %d %d\n" % tuple(t + 1 + len(W)) for t in bq)
    f.write("f " + " ".join(str(len(W) + 1 + j) for j in range(24)) + "\n")
    f.write("f " + " ".join(str(len(W) + 72 + 24 - j) for j in range(24)) + "\n")
print(sum(p.stat().st_size for p in out.iterdir()) // 1024, "kB", sorted((p.name, p.stat().st_size) for p in out.iterdir()))
