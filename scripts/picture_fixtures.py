#!/usr/bin/env python3
"""Pictures of a hem of known shape, encoded by Pillow (libjpeg-turbo, libtiff) and ImageMagick, for tests/import_images.rs.

Usage: scripts/picture_fixtures.py [tests/files/images]

The hem: radius 0.125 + 0.030 cos 6(phi - 0.137) m about (0.2013, 0.1978) m, seen in a field of 0.4 x 0.4 m, lower left corner at the origin.
Each pixel is the mean of 16 x 16 points; the lens blurs by 0.7 px; light is 0.05 on the cloth and 0.85 on the ground.
"""
import io, pathlib, subprocess, sys
import numpy as np
from PIL import Image

N, VIEW = 256, 0.4
to = pathlib.Path(sys.argv[1] if len(sys.argv) > 1 else "tests/files/images")
to.mkdir(parents=True, exist_ok=True)


def covered(n=N, samples=16):
    total = np.zeros((n, n))
    at = (np.arange(n) + 0.0)[None, :]
    for i in range(samples):
        for j in range(samples):
            x = (at + (i + 0.5) / samples) * VIEW / n - 0.2013
            y = VIEW - (at.T + (j + 0.5) / samples) * VIEW / n - 0.1978
            total += np.hypot(x, y) < 0.125 + 0.030 * np.cos(6 * (np.arctan2(y, x) - 0.137))
    return total / samples**2


def blurred(a, sigma=0.7):
    k = np.arange(-4, 5)
    w = np.exp(-0.5 * (k / sigma) ** 2)
    w /= w.sum()
    pad = np.pad(a, 4, mode="edge")
    pad = sum(w[i] * pad[:, i : i + a.shape[1]] for i in range(9))
    return sum(w[i] * pad[i : i + a.shape[0], :] for i in range(9))


def srgb(light):
    return np.where(light <= 0.0031308, 12.92 * light, 1.055 * np.maximum(light, 1e-9) ** (1 / 2.4) - 0.055)


light = 0.85 + blurred(covered()) * (0.05 - 0.85)
grey = Image.fromarray(np.round(255 * light).astype(np.uint8))
encoded = np.round(255 * srgb(light)).astype(np.uint8)
colour = Image.fromarray(np.dstack([encoded, (encoded * 0.97).astype(np.uint8), (encoded * 0.93).astype(np.uint8)]))


def magick(source, name, *arguments):
    buffer = io.BytesIO()
    source.save(buffer, "PNG")
    subprocess.run(["convert", "png:-", *arguments, str(to / name)], input=buffer.getvalue(), check=True)


grey.save(to / "pillow_75.jpg", quality=75)
magick(grey, "magick_progressive_85.jpg", "-interlace", "JPEG", "-quality", "85")
# A phone held on its side: stored turned, the camera says orientation 6, and its make.
exif = Image.Exif()
exif[0x0112], exif[0x010F], exif[0x0110] = 6, "Example", "Phone"
colour.transpose(Image.Transpose.ROTATE_90).save(to / "phone_orientation_6.jpg", quality=88, exif=exif)
colour.convert("CMYK").save(to / "pillow_cmyk.jpg", quality=90)
magick(grey, "magick_cmyk.jpg", "-colorspace", "CMYK", "-quality", "90")
grey.quantize(64).save(to / "pillow_palette.png", optimize=True)
magick(grey, "magick_16.png", "-depth", "16", "-define", "png:bit-depth=16", "-define", "png:color-type=0")
alpha = Image.merge("LA", (Image.new("L", (N, N), 0), Image.fromarray(np.round(255 * blurred(covered())).astype(np.uint8))))
alpha.save(to / "pillow_alpha.png", optimize=True)
magick(grey, "magick_lzw_16.tif", "-depth", "16", "-compress", "LZW")
magick(colour, "magick_zip_rgb.tif", "-compress", "Zip")
Image.fromarray(np.round(65535 * light).astype(np.uint16)).save(to / "pillow_16.tif", compression="tiff_deflate")
grey.save(to / "pillow_two_pages.tif", compression="tiff_deflate", save_all=True, append_images=[Image.new("L", (N, N), 128)])
grey.save(to / "pillow_8.bmp")
grey.quantize(16).save(to / "pillow_palette.tif", compression="tiff_lzw")
grey.save(to / "pillow_gif.gif")
grey.save(to / "animated.png", save_all=True, append_images=[Image.new("L", (N, N), 128)])
for file in sorted(to.iterdir()):
    print(f"{file.stat().st_size:8d} {file.name}")
