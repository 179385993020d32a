# Poses of a recording as table, plot and overlay; cell by cell (# %%) in an editor that knows cells, or as a script:
#   pose_plot.py camera.yaml parts.yaml recording

# %% What to look at
import dataclasses
import sys

import numpy as np
from PIL import Image, ImageDraw

import cylpose

camera_file, parts_file, recording = sys.argv[1:4]
camera = cylpose.load_camera(camera_file)
parts = cylpose.load_parts(parts_file)

# %% Poses of all frames, filtered over time; the overlay of one of them
results = []
for result in cylpose.stream(recording, camera, parts, filter=True, images=True):
    if not results and result.parts[0].status == "ok":
        picture = cylpose.overlay(result.image, camera, parts, result)
        Image.fromarray(picture[..., ::-1]).save("overlay.png")
    results.append(dataclasses.replace(result, image=None))  # or every image would stay in memory

# %% As a table: the columns of a poses CSV
table = cylpose.to_table(results)
poses = table[(table["part"] == parts[0].name) & (table["status"] != "none")]
print(f"{len(results)} frames, {np.count_nonzero(poses['status'] == 'ok')} with {parts[0].name} measured")
for row in poses[:: max(1, len(poses) // 10)]:
    print(f"{row['timestamp_s']:7.2f} s  {row['status']:9}  z {row['cz']:.4f} m, sigma {1000 * row['sigma_cz']:.2f} mm")

# %% Depth over time, with the band of two sigmas
WIDTH, HEIGHT, MARGIN = 900, 400, 40
plot = Image.new("RGB", (WIDTH, HEIGHT), "white")
draw = ImageDraw.Draw(plot)
t, z, band = poses["timestamp_s"], poses["cz"], 2 * poses["sigma_cz"]
low, high = (z - band).min(), (z + band).max()


def points(values):
    x = np.interp(t, (t[0], t[-1]), (MARGIN, WIDTH - MARGIN))
    return list(zip(x.tolist(), np.interp(values, (low, high), (HEIGHT - MARGIN, MARGIN)).tolist()))


draw.polygon(points(z + band) + points(z - band)[::-1], fill="lightskyblue")
draw.line(points(z), fill="navy", width=2)
draw.text((MARGIN, MARGIN // 3), f"{parts[0].name}: z from {low:.4f} to {high:.4f} m, {t[0]:.2f} to {t[-1]:.2f} s", "black")
plot.save("depth.png")
