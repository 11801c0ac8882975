"""The demo: a still life on a terrace at sunset, made from nothing but Blender's own means.

    python scenes/make_demo.py out/demo.blend

Glass, metal and plastic stand on a floor of inlaid terrazzo, lit by a sky and a soft box. The
floor's texture and the sky are computed here and packed into the file, so the .blend stands alone. The
floor is a checkerboard in log-polar coordinates, (ln r, θ), which keeps its diamonds similar at every
distance from the middle. Runs under bpy 4.5 and 5.2.
"""

import math
import sys
from pathlib import Path

import bpy  # before the others, which it brings along

# isort: split
import bmesh
import numpy as np
from mathutils import Vector

FLOOR_RADIUS = 9.0
SUN = np.array([-0.105, 0.99, 0.098])  # where it stands: low behind the gate


# ---------------------------------------------------------------- pictures, computed


def packed_image(name, pixels, colorspace):
    """A Blender image of `pixels` (H, W, 3), bottom row first, stored inside the .blend."""
    height, width, _ = pixels.shape
    is_float = colorspace.startswith("Linear")
    image = bpy.data.images.new(name, width, height, float_buffer=is_float)
    image.colorspace_settings.name = colorspace
    rgba = np.ones((height, width, 4), np.float32)
    rgba[..., :3] = pixels
    image.pixels.foreach_set(rgba.reshape(-1))
    image.file_format = "OPEN_EXR" if is_float else "PNG"
    image.pack()
    return image


def value_noise(rng, shape, cells):
    """Smooth noise in [0, 1] that wraps around, with `cells` (rows, columns) random values."""
    grid = rng.random(cells)
    for axis, n in enumerate(shape):
        x = np.arange(n) * (cells[axis] / n)
        i = x.astype(int)
        f = x - i
        f = (f * f * (3 - 2 * f)).reshape((-1, 1) if axis == 0 else (1, -1))
        low, high = np.take(grid, i, axis), np.take(grid, (i + 1) % cells[axis], axis)
        grid = low + (high - low) * f
    return grid


def chips(rng, shape, cells):
    """Terrazzo: to each pixel the number of its nearest random point, and how far inside its cell it is."""
    points = rng.random((cells, cells, 2)) * 0.9 + 0.05
    y, x = (np.arange(n, dtype=np.float32) * (cells / n) for n in shape)
    iy, ix = y.astype(int)[:, None], x.astype(int)[None, :]
    nearest = np.full(shape, 9.0, np.float32)
    second, number = nearest.copy(), np.zeros(shape, np.int32)
    for dy in (-1, 0, 1):
        for dx in (-1, 0, 1):
            cy, cx = (iy + dy) % cells, (ix + dx) % cells
            py, px = points[cy, cx, 0] + iy + dy, points[cy, cx, 1] + ix + dx
            distance = np.hypot(y[:, None] - py, x[None, :] - px).astype(np.float32)
            closer = distance < nearest
            second = np.minimum(second, np.maximum(distance, nearest))
            nearest = np.minimum(nearest, distance)
            number = np.where(closer, cy * cells + cx, number)
    return number, second - nearest


def floor_pictures(size=2048, arms=16):
    """The floor's colour (sRGB) and its mask of brass lines, each (size, size, 3)."""
    rng = np.random.default_rng(7)
    axis = np.linspace(-FLOOR_RADIUS, FLOOR_RADIUS, size)
    x, y = np.meshgrid(axis, axis)
    r = np.hypot(x, y) + 1e-6
    turns = arms * np.arctan2(y, x) / (2 * np.pi)
    log_r = arms * np.log(r) / (2 * np.pi)
    u, v = turns + log_r, turns - log_r
    dark = (np.floor(u) + np.floor(v)) % 2 > 0
    to_line = np.minimum(np.abs(u - np.rint(u)), np.abs(v - np.rint(v)))
    to_line *= 2 * np.pi * r / arms / math.sqrt(2)  # in metres
    rings = np.min([np.abs(r - radius) for radius in (2.02, FLOOR_RADIUS - 0.35)], axis=0)
    dark &= r < FLOOR_RADIUS - 0.35
    brass = np.clip((0.016 - np.minimum(to_line, rings)) / 0.009 + 0.5, 0, 1)
    brass[r > FLOOR_RADIUS - 0.3] = 0

    number, inside = chips(rng, (size, size), 230)
    chip = np.clip((inside - 0.18) / 0.1, 0, 1) * (rng.random(230 * 230) < 0.5)[number]
    light_stones = np.array([[0.72, 0.42, 0.33], [0.94, 0.90, 0.84], [0.55, 0.56, 0.52], [0.85, 0.68, 0.50]])
    dark_stones = np.array([[0.12, 0.28, 0.30], [0.20, 0.42, 0.42], [0.62, 0.66, 0.60], [0.08, 0.16, 0.19]])
    which = rng.integers(0, 4, 230 * 230)[number]
    stones = np.where(dark[..., None], dark_stones[which], light_stones[which])
    cement = np.where(dark[..., None], (0.10, 0.22, 0.25), (0.83, 0.77, 0.68))
    cement = cement * (0.94 + 0.12 * value_noise(rng, (size, size), (64, 64)))[..., None]
    color = cement + (stones - cement) * chip[..., None]
    color = color + (np.array([0.93, 0.76, 0.46]) - color) * brass[..., None]
    return color, np.repeat(brass[..., None], 3, axis=2)


def sky_picture(height=512):
    """Equirectangular sky, (height, 2·height, 3) linear: dusk above, haze below, a wide sun between."""
    rng = np.random.default_rng(3)
    elevation = (np.arange(height) + 0.5) / height * np.pi - np.pi / 2
    azimuth = np.pi - (np.arange(2 * height) + 0.5) / height * np.pi
    phi, theta = np.meshgrid(azimuth, elevation)
    x, y, z = np.cos(theta) * np.cos(phi), np.cos(theta) * np.sin(phi), np.sin(theta)
    cosine = x * SUN[0] + y * SUN[1] + z * SUN[2]

    stops = (-1.0, -0.20, -0.02, 0.03, 0.09, 0.20, 0.45, 1.0)
    colors = np.array(
        [(0.04, 0.04, 0.08), (0.08, 0.06, 0.11), (0.30, 0.12, 0.11), (0.46, 0.17, 0.09),
         (0.25, 0.14, 0.18), (0.09, 0.13, 0.26), (0.07, 0.15, 0.33), (0.06, 0.13, 0.30)]
    )  # fmt: skip
    sky = np.stack([np.interp(z, stops, channel) for channel in colors.T], axis=-1)
    shape = z.shape
    cloud = sum(value_noise(rng, shape, (24 * k, 10 * k)) / k for k in (1, 2, 4)) / 1.75
    cover = np.clip((cloud - 0.5) * 4, 0, 1) * np.clip(z * 6, 0, 1) * np.clip(1.6 - 2.2 * z, 0, 1)
    lit = np.array([0.75, 0.34, 0.24]) * (0.5 + 0.9 * np.exp((cosine - 1) * 4))[..., None]
    sky = sky + (lit - sky) * 0.6 * cover[..., None]
    for sharpness, strength in ((1500.0, 18.0), (200.0, 1.2), (20.0, 0.30)):
        sky = sky + np.exp((cosine - 1) * sharpness)[..., None] * strength * np.array([1.0, 0.60, 0.28])
    window = np.exp((x * 0.80 - y * 0.42 + z * 0.43 - 1) * 9)  # cool light from the viewer's right
    return sky + window[..., None] * np.array([1.3, 1.6, 2.0])


# ---------------------------------------------------------------- materials


def material(name, kind="BsdfPrincipled", **values):
    """A material of one shader node; `values` by input name, with _ for a blank."""
    made = bpy.data.materials.new(name)
    made.use_nodes = True
    nodes, links = made.node_tree.nodes, made.node_tree.links
    nodes.clear()
    output, shader = nodes.new("ShaderNodeOutputMaterial"), nodes.new("ShaderNode" + kind)
    shader.location = (-300, 0)
    links.new(shader.outputs["BSDF"], output.inputs["Surface"])
    for key, value in values.items():
        socket = shader.inputs[key.replace("_", " ")]
        socket.default_value = (*value, 1.0) if isinstance(value, tuple) else value
    return made


def floor_material():
    """Polished terrazzo: the mask makes its brass lines metallic."""
    made = material("Terrazzo", Roughness=0.22)
    nodes, links = made.node_tree.nodes, made.node_tree.links
    shader = nodes["Principled BSDF"]
    color, mask = floor_pictures()
    coordinates = nodes.new("ShaderNodeTexCoord")
    coordinates.location = (-900, 0)
    for row, (name, pixels, space, socket) in enumerate(
        (("Terrazzo", color, "sRGB", "Base Color"), ("Brass", mask, "Non-Color", "Metallic"))
    ):
        texture = nodes.new("ShaderNodeTexImage")
        texture.location = (-650, -300 * row)
        texture.image = packed_image(name, pixels, space)
        links.new(coordinates.outputs["UV"], texture.inputs["Vector"])
        links.new(texture.outputs["Color"], shader.inputs[socket])
    return made


def checker_material():
    """A checkerboard of satin plastic for the plinth's step."""
    made = material("Checker", Roughness=0.4)
    nodes, links = made.node_tree.nodes, made.node_tree.links
    coordinates, mapping = nodes.new("ShaderNodeTexCoord"), nodes.new("ShaderNodeMapping")
    checker = nodes.new("ShaderNodeTexChecker")
    for x, node in ((-900, coordinates), (-700, mapping), (-500, checker)):
        node.location = (x, 0)
    mapping.inputs["Rotation"].default_value = (0.0, 0.0, math.radians(45))
    checker.inputs["Scale"].default_value = 9.0
    checker.inputs["Color1"].default_value = (0.75, 0.68, 0.56, 1)
    checker.inputs["Color2"].default_value = (0.03, 0.10, 0.12, 1)
    links.new(coordinates.outputs["Object"], mapping.inputs["Vector"])
    links.new(mapping.outputs["Vector"], checker.inputs["Vector"])
    links.new(checker.outputs["Color"], nodes["Principled BSDF"].inputs["Base Color"])
    return made


# ---------------------------------------------------------------- shapes


def placed(name, made, location, rotation=(0, 0, 0), smooth=30, bevel=0.0, segments=4):
    """Finish the active object: name, material, place, smooth shading below an angle, bevelled edges."""
    thing = bpy.context.object
    thing.name = name
    thing.data.materials.append(made)
    thing.location = location
    thing.rotation_euler = [math.radians(a) for a in rotation]
    if bevel:
        modifier = thing.modifiers.new("Bevel", "BEVEL")
        modifier.width, modifier.segments, modifier.limit_method = bevel, segments, "ANGLE"
        modifier.harden_normals = True
    if thing.type == "MESH" and smooth:
        bpy.ops.object.shade_smooth_by_angle(angle=math.radians(smooth))
    return thing


def cylinder(name, made, radius, height, location, bevel=0.02, vertices=128):
    bpy.ops.mesh.primitive_cylinder_add(vertices=vertices, radius=radius, depth=height)
    x, y, z = location
    return placed(name, made, (x, y, z + height / 2), bevel=bevel)


def sphere(name, made, radius, x, y, z=0.0):
    bpy.ops.mesh.primitive_uv_sphere_add(segments=96, ring_count=48, radius=radius)
    return placed(name, made, (x, y, z + radius), smooth=180)


def floor():
    bpy.ops.mesh.primitive_cylinder_add(vertices=256, radius=FLOOR_RADIUS, depth=0.5)
    thing = placed("Floor", floor_material(), (0, 0, -0.25), bevel=0.05)
    mesh = thing.data  # seen from above: u, v follow x, y
    layer = mesh.uv_layers.active.data
    for loop in mesh.loops:
        x, y, _ = mesh.vertices[loop.vertex_index].co
        layer[loop.index].uv = (x / FLOOR_RADIUS / 2 + 0.5, y / FLOOR_RADIUS / 2 + 0.5)


def plinth():
    cylinder("Step", checker_material(), 1.55, 0.16, (0, 0, 0), bevel=0.03)
    navy = material("Navy", Base_Color=(0.012, 0.045, 0.075), Roughness=0.12)
    cylinder("Plinth", navy, 1.05, 0.5, (0, 0, 0.16), bevel=0.05)
    brass = material("Brass", Base_Color=(1.0, 0.72, 0.30), Metallic=1.0, Roughness=0.18)
    bpy.ops.mesh.primitive_torus_add(major_radius=1.05, minor_radius=0.03, major_segments=128)
    placed("Plinth band", brass, (0, 0, 0.42), smooth=180)


def suzanne():
    bpy.ops.mesh.primitive_monkey_add(size=1.7)
    gold = material(
        "Gold", "BsdfMetallic", Base_Color=(1.0, 0.70, 0.29), Edge_Tint=(1.0, 0.92, 0.72), Roughness=0.2
    )
    thing = placed("Suzanne", gold, (0.0, -0.05, 1.36), (-14, 0, 12), smooth=180)
    modifier = thing.modifiers.new("Subdivision", "SUBSURF")
    modifier.levels = modifier.render_levels = 3


def gate():
    """The ring behind: a circle curve with a round bevel, half sunk into the terrace."""
    bpy.ops.curve.primitive_bezier_circle_add(radius=2.2)
    steel = material(
        "Steel", "BsdfMetallic", Base_Color=(0.66, 0.65, 0.63), Edge_Tint=(0.9, 0.9, 0.92), Roughness=0.28
    )
    thing = placed("Gate", steel, (-0.05, 2.2, 1.62), (90, 0, 0))
    thing.data.bevel_depth, thing.data.bevel_resolution, thing.data.resolution_u = 0.13, 8, 48


def glassware():
    glass = material("Glass", "BsdfGlass", Color=(1.0, 1.0, 1.0), Roughness=0.0, IOR=1.5)
    sphere("Glass ball", glass, 0.66, -2.02, -1.25)
    tinted = material("Tinted glass", "BsdfGlass", Color=(0.80, 0.97, 0.93), Roughness=0.0, IOR=1.52)
    bpy.ops.mesh.primitive_ico_sphere_add(subdivisions=1, radius=0.56)
    placed("Gem", tinted, (2.02, -1.75, 0.50), (20.9, 0, 24), smooth=0, bevel=0.02, segments=2)
    frosted = material("Frosted glass", "BsdfGlass", Color=(0.98, 0.86, 0.80), Roughness=0.25, IOR=1.45)
    cylinder("Frosted column", frosted, 0.30, 1.5, (2.55, 0.15, 0), bevel=0.06)


def metals():
    copper = material("Copper", Base_Color=(0.955, 0.52, 0.36), Metallic=1.0, Roughness=0.05)
    sphere("Copper ball", copper, 0.38, -1.15, -1.85)
    chrome = material("Chrome", Base_Color=(0.82, 0.83, 0.85), Metallic=1.0, Roughness=0.0)
    sphere("Mirror ball", chrome, 0.26, 0.75, -1.95)


def plastics():
    coral = material("Coral plastic", Base_Color=(0.78, 0.10, 0.055), Roughness=0.25)
    bpy.ops.mesh.primitive_cube_add(size=0.52)
    stairs = placed("Stairs", coral, (-3.35, 0.35, 0.26), (0, 0, 28), bevel=0.06)
    array = stairs.modifiers.new("Array", "ARRAY")
    array.count, array.use_relative_offset, array.use_constant_offset = 3, False, True
    array.constant_offset_displace = (0.56, 0.30, 0.0)
    bpy.ops.mesh.primitive_cube_add(size=0.52)
    ochre = material("Ochre plastic", Base_Color=(0.80, 0.42, 0.05), Roughness=0.3)
    placed("Top cube", ochre, (-2.98, 0.60, 0.80), (0, 0, 48), bevel=0.06)

    teal = material("Teal bowl", Base_Color=(0.02, 0.30, 0.30), Roughness=0.18)
    bpy.ops.mesh.primitive_uv_sphere_add(segments=96, ring_count=48, radius=0.42)
    bowl = placed("Bowl", teal, (1.45, -2.15, 0.45), smooth=60)
    cut = bmesh.new()  # the lower half, then a wall
    cut.from_mesh(bowl.data)
    bmesh.ops.delete(cut, geom=[v for v in cut.verts if v.co.z > 1e-3], context="VERTS")
    cut.to_mesh(bowl.data)
    cut.free()
    wall = bowl.modifiers.new("Wall", "SOLIDIFY")
    wall.thickness, wall.offset = 0.03, 1.0
    rim = bowl.modifiers.new("Rim", "BEVEL")
    rim.width, rim.segments, rim.limit_method = 0.012, 3, "ANGLE"


def equation():
    """The rendering equation in plastic letters on the floor, in front of everything."""
    bpy.ops.object.text_add()
    made = material("Letters", Base_Color=(0.86, 0.13, 0.05), Roughness=0.25)
    thing = placed("Rendering equation", made, (-0.05, -2.95, 0.0), (75, 0, 0))
    text = thing.data
    text.body, text.size, text.align_x = "L = E + ∫ f L dω", 0.46, "CENTER"
    text.extrude, text.bevel_depth, text.bevel_resolution = 0.05, 0.008, 2


# ---------------------------------------------------------------- light, camera, settings


def sky():
    world = bpy.data.worlds.new("Dusk")
    bpy.context.scene.world = world
    world.use_nodes = True
    nodes, links = world.node_tree.nodes, world.node_tree.links
    nodes.clear()
    output, background = nodes.new("ShaderNodeOutputWorld"), nodes.new("ShaderNodeBackground")
    texture = nodes.new("ShaderNodeTexEnvironment")
    texture.image = packed_image("Sky", sky_picture(), "Linear Rec.709")
    texture.location, background.location = (-500, 0), (-200, 0)
    links.new(texture.outputs["Color"], background.inputs["Color"])
    links.new(background.outputs["Background"], output.inputs["Surface"])


def soft_box(name, size, power, color, location, target):
    light = bpy.data.lights.new(name, "AREA")
    light.shape, light.size, light.size_y = "RECTANGLE", *size
    light.energy, light.color = power, color
    thing = bpy.data.objects.new(name, light)
    bpy.context.scene.collection.objects.link(thing)
    thing.location = location
    thing.rotation_euler = (Vector(target) - Vector(location)).to_track_quat("-Z", "Y").to_euler()


def camera():
    data = bpy.data.cameras.new("Camera")
    thing = bpy.data.objects.new("Camera", data)
    bpy.context.scene.collection.objects.link(thing)
    thing.location = (0.55, -9.4, 2.05)
    thing.rotation_euler = (Vector((0.0, 0, 1.28)) - thing.location).to_track_quat("-Z", "Y").to_euler()
    data.lens = 41
    data.dof.use_dof = True
    data.dof.focus_distance = 8.6
    data.dof.aperture_fstop, data.dof.aperture_blades = 1.0, 7
    bpy.context.scene.camera = thing


def settings():
    scene = bpy.context.scene
    scene.render.resolution_x, scene.render.resolution_y = 640, 360
    scene.view_settings.view_transform = "AgX"
    scene.view_settings.look = "AgX - Medium High Contrast"
    scene.view_settings.exposure = 0.1


def main(path):
    bpy.ops.wm.read_factory_settings(use_empty=True)
    for build in (floor, plinth, suzanne, gate, glassware, metals, plastics, equation, sky, camera, settings):
        build()
    soft_box("Key", (7.0, 7.0), 700, (1.0, 0.90, 0.78), (-5.0, -5.5, 5.5), (0, 0, 0.8))
    path.parent.mkdir(parents=True, exist_ok=True)
    bpy.context.preferences.filepaths.save_version = 0  # no demo.blend1
    bpy.ops.wm.save_as_mainfile(filepath=str(path.resolve()), compress=True)


if __name__ == "__main__":
    main(Path(sys.argv[-1]) if len(sys.argv) > 1 else Path("out/demo.blend"))
