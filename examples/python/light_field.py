"""Where the light of an LED goes in a curved membrane, by four models, and the images it makes.

Run: python3 light_field.py [picture.png]
"""

import sys

import matplotlib
import numpy as np

matplotlib.use("Agg")
import matplotlib.pyplot as plt

import gelight

width, height = 320, 240
sensor = gelight.geltip(width, height)
raster = gelight.rasterize(sensor.membrane, sensor.camera)

# A ball pressed 1.5 mm into the tip, a little beside its middle.
depth = np.full((height, width), np.inf, np.float32)
ball = gelight.icosphere(5, 0.005)
gelight.rasterize_into(depth, ball, gelight.Pose(None, [0.003, 0.002, 0.0480]), sensor.camera)

models = {
    "linear": gelight.LinearLight,
    "plane": gelight.PlaneLight,
    "geodesic": gelight.GeodesicLight,
    "transport": gelight.TransportLight,
}
figure, axes = plt.subplots(2, 4, figsize=(13, 5.2), layout="constrained")
for (name, kind), (above, below) in zip(models.items(), axes.T):
    model = kind(sensor.membrane)
    led = sensor.leds[1]
    if kind is gelight.TransportLight:  # without an emission it starts at a vertex
        led = gelight.nearest_vertex(sensor.membrane, sensor.membrane.position(led))
    directions = gelight.bake(model.field(led, raster), raster)
    step = np.s_[height // 30 :: height // 15, height // 30 :: height // 15]
    v, u = np.mgrid[:height, :width]
    above.imshow(raster.depth, cmap="bone")
    above.quiver(u[step], v[step], directions[step][..., 0], directions[step][..., 1],
                 angles="xy", color="tab:red")
    above.set(title=f"{name} light", xticks=[], yticks=[])
    below.imshow(gelight.tactile_renderer(sensor, model).render(depth))
    below.set(xticks=[], yticks=[])
figure.savefig(sys.argv[1] if len(sys.argv) > 1 else "light_field.png", dpi=80)
