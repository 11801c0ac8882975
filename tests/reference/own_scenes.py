"""Small Blender scenes, each about one thing, to be rendered by Cycles and by us.

A function makes the current Blender file; `SCENES` lists them all by name.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import partial
from typing import Any

import bpy
import numpy as np
from mathutils import Vector

FIVE = bpy.app.version >= (5, 0, 0)


def empty() -> None:
    """No objects, a black world, a camera that looks at the origin from the front right."""
    bpy.ops.wm.read_factory_settings(use_empty=True)
    scene = bpy.context.scene
    scene.world = bpy.data.worlds.new("world")
    if not FIVE:
        scene.world.use_nodes = True
    sky((0, 0, 0))
    scene.camera = add("camera", bpy.data.cameras.new("camera"), (2.2, -4.2, 2.6))
    scene.camera.data.lens = 40
    look_at(scene.camera, (0, 0, 0.5))


def add(name: str, data: Any, place: tuple[float, float, float] = (0, 0, 0)) -> Any:
    """Link a new object."""
    thing = bpy.data.objects.new(name, data)
    thing.location = place
    bpy.context.scene.collection.objects.link(thing)
    return thing


def look_at(thing: Any, target: tuple[float, float, float]) -> None:
    """Turn its −Z toward a point."""
    thing.rotation_euler = (Vector(target) - thing.location).to_track_quat("-Z", "Y").to_euler()


def sky(colour: tuple[float, float, float], strength: float = 1.0) -> Any:
    """A world of one colour; returns its Background node."""
    tree = bpy.context.scene.world.node_tree
    tree.nodes.clear()
    background = tree.nodes.new("ShaderNodeBackground")
    background.inputs["Color"].default_value = (*colour, 1)
    background.inputs["Strength"].default_value = strength
    tree.links.new(background.outputs[0], tree.nodes.new("ShaderNodeOutputWorld").inputs["Surface"])
    return background


def material(kind: str, props: dict[str, Any] | None = None, **inputs: Any) -> Any:
    """A material of one shader node; underscores in input names stand for spaces."""
    made = bpy.data.materials.new(kind)
    if not FIVE:
        made.use_nodes = True
    tree = made.node_tree
    tree.nodes.clear()
    node = tree.nodes.new("ShaderNode" + kind)
    for name, value in (props or {}).items():
        setattr(node, name, value)
    for name, value in inputs.items():
        socket = node.inputs[name.replace("_", " ")]
        socket.default_value = (*value, 1) if isinstance(value, tuple) and len(value) == 3 else value
    tree.links.new(node.outputs[0], tree.nodes.new("ShaderNodeOutputMaterial").inputs["Surface"])
    return made


def mixed(first: Any, kind: str, factor: float, **inputs: Any) -> Any:
    """`first` mixed with a second shader."""
    tree = first.node_tree
    output = next(n for n in tree.nodes if n.bl_idname == "ShaderNodeOutputMaterial")
    one = output.inputs["Surface"].links[0].from_node
    two, mix = tree.nodes.new("ShaderNode" + kind), tree.nodes.new("ShaderNodeMixShader")
    for name, value in inputs.items():
        two.inputs[name].default_value = (*value, 1) if isinstance(value, tuple) else value
    mix.inputs[0].default_value = factor
    tree.links.new(one.outputs[0], mix.inputs[1])
    tree.links.new(two.outputs[0], mix.inputs[2])
    tree.links.new(mix.outputs[0], output.inputs["Surface"])
    return first


def floor(colour: tuple[float, float, float] = (0.7, 0.65, 0.6), size: float = 6.0) -> Any:
    """A grey plane at z = 0."""
    bpy.ops.mesh.primitive_plane_add(size=size)
    plane = bpy.context.object
    plane.data.materials.append(material("BsdfDiffuse", Color=colour))
    return plane


def ball(look: Any, place: tuple[float, float, float] = (0, 0, 0.7), radius: float = 0.7) -> Any:
    """A smooth sphere."""
    bpy.ops.mesh.primitive_uv_sphere_add(radius=radius, location=place, segments=48, ring_count=24)
    sphere = bpy.context.object
    bpy.ops.object.shade_smooth()
    sphere.data.materials.append(look)
    return sphere


def cube(look: Any, place: tuple[float, float, float], size: float = 0.6) -> Any:
    """A flat cube, turned a little."""
    bpy.ops.mesh.primitive_cube_add(size=size, location=place, rotation=(0, 0, 0.5))
    bpy.context.object.data.materials.append(look)
    return bpy.context.object


def lamp(kind: str, power: float, place: tuple[float, float, float] = (1.2, -0.8, 2.2), **props: Any) -> Any:
    """A lamp that shines on the origin."""
    light = bpy.data.lights.new("lamp", kind)
    light.energy, light.color = power, (1.0, 0.9, 0.7)
    for name, value in props.items():
        setattr(light, name, value)
    thing = add("lamp", light, place)
    look_at(thing, (0, 0, 0.3))
    return thing


def lit_by(kind: str, power: float, **props: Any) -> None:
    """A diffuse ball and a box on the floor under one lamp."""
    empty()
    floor()
    ball(material("BsdfDiffuse", Color=(0.8, 0.3, 0.2)))
    cube(material("BsdfDiffuse", Color=(0.2, 0.4, 0.8)), (-1.1, 0.4, 0.3))
    lamp(kind, power, **props)


def made_of(kind: str, props: dict[str, Any] | None = None, **inputs: Any) -> None:
    """A ball of one material on the floor under an area lamp and a grey sky."""
    empty()
    floor()
    ball(material(kind, props, **inputs))
    lamp("AREA", 60, size=1.0)
    sky((0.4, 0.5, 0.6), 0.5)


def mesh_light() -> None:
    """A glowing cube, a quad that glows on both sides, nothing else."""
    empty()
    floor()
    cube(material("Emission", Color=(1.0, 0.8, 0.5), Strength=6.0), (-0.9, 0.2, 0.5))
    cube(material("BsdfDiffuse", Color=(0.6, 0.6, 0.6)), (0.6, 0.6, 0.3))
    bpy.ops.mesh.primitive_plane_add(size=0.5, location=(0.8, -0.4, 0.8), rotation=(1.2, 0, 0.4))
    bpy.context.object.data.materials.append(material("Emission", Color=(0.4, 0.6, 1.0), Strength=8.0))


def environment_map() -> None:
    """A sky image with a small sun, turned about the vertical."""
    empty()
    floor()
    ball(material("BsdfDiffuse", Color=(0.7, 0.7, 0.7)))
    cube(material("BsdfAnisotropic", Color=(0.9, 0.8, 0.6), Roughness=0.3), (-1.1, 0.4, 0.3))
    background = sky((0, 0, 0))
    height, width = 64, 128
    rgba = np.ones((height, width, 4), np.float32)
    rgba[..., :3] = np.linspace(0.1, 0.6, height)[:, None, None] * np.array([0.6, 0.8, 1.0])
    rgba[45:47, 30:32, :3] = (300, 250, 200)
    image = bpy.data.images.new("sky", width, height, float_buffer=True)
    image.colorspace_settings.name = "Linear Rec.709"
    image.pixels.foreach_set(rgba.ravel())
    image.file_format = "OPEN_EXR"
    image.pack()
    tree = bpy.context.scene.world.node_tree
    texture, mapping = tree.nodes.new("ShaderNodeTexEnvironment"), tree.nodes.new("ShaderNodeMapping")
    texture.image = image
    mapping.inputs["Rotation"].default_value = (0, 0, 1.0)
    coordinate = tree.nodes.new("ShaderNodeTexCoord")
    tree.links.new(coordinate.outputs["Generated"], mapping.inputs["Vector"])
    tree.links.new(mapping.outputs["Vector"], texture.inputs["Vector"])
    tree.links.new(texture.outputs["Color"], background.inputs["Color"])


def transparent_shadows() -> None:
    """Coloured clear panes between lamp and floor, one of them only half clear."""
    empty()
    floor()
    ball(material("BsdfDiffuse", Color=(0.7, 0.7, 0.7)), radius=0.4, place=(0, 0, 0.4))
    clear = material("BsdfTransparent", Color=(0.9, 0.5, 0.3))
    half = material("BsdfDiffuse", Color=(0.2, 0.7, 0.3))
    mixed(half, "BsdfTransparent", 0.6, Color=(0.9, 0.9, 1.0))
    for look, place in ((clear, (0.3, -0.2, 1.2)), (half, (-0.5, 0.1, 1.5))):
        bpy.ops.mesh.primitive_plane_add(size=1.0, location=place)
        bpy.context.object.data.materials.append(look)
    lamp("AREA", 80, place=(0.3, -0.3, 2.6), size=0.5)
    sky((0.2, 0.2, 0.25))


def image_texture() -> None:
    """An sRGB checker with colours through UVs, interpolated."""
    lit_by("AREA", 60, size=1.0)
    image = bpy.data.images.new("checker", 8, 8)
    i, j = np.meshgrid(np.arange(8), np.arange(8), indexing="ij")
    rgba = np.stack([(i + j) % 2 * 0.8 + 0.1, i / 8, j / 8, np.ones((8, 8))], -1).astype(np.float32)
    image.pixels.foreach_set(rgba.ravel())
    image.pack()
    plane = next(o for o in bpy.data.objects if o.name.startswith("Plane"))
    tree = plane.data.materials[0].node_tree
    texture = tree.nodes.new("ShaderNodeTexImage")
    texture.image = image
    shader = next(n for n in tree.nodes if n.bl_idname == "ShaderNodeBsdfDiffuse")
    tree.links.new(texture.outputs["Color"], shader.inputs["Color"])


def with_camera(change: Callable[[Any], None]) -> None:
    """A row of boxes seen by a camera with one thing changed."""
    empty()
    floor((0.5, 0.5, 0.5))
    for k in range(4):
        colour = (0.8, 0.2 * k, 0.6 - 0.2 * k)
        cube(material("BsdfDiffuse", Color=colour), (0.9 * k - 1.4, 0.8 * k - 1.0, 0.3))
    lamp("SUN", 3.0, angle=0.1)
    sky((0.3, 0.4, 0.5))
    change(bpy.context.scene.camera.data)


def panorama(kind: str, **values: Any) -> None:
    """The same row of boxes all around a camera among them."""

    def change(camera: Any) -> None:
        owner = camera if hasattr(camera, "panorama_type") else camera.cycles
        camera.type = "PANO"
        owner.panorama_type = kind
        for name, value in values.items():
            setattr(owner if hasattr(owner, name) else camera, name, value)

    with_camera(change)


def set_to(**values: Any) -> Callable[[Any], None]:
    """A change of camera settings; `dof_` and a name sets one of its depth of field."""

    def change(camera: Any) -> None:
        for name, value in values.items():
            owner = camera.dof if name.startswith("dof_") else camera
            setattr(owner, name.removeprefix("dof_"), value)

    return change


def stretched() -> None:
    """Instances with non-uniform and negative scales, smooth and flat."""
    empty()
    floor()
    one = ball(material("BsdfDiffuse", Color=(0.8, 0.5, 0.2)), (-0.9, 0, 0.6), 0.4)
    one.scale, one.rotation_euler = (1.0, 0.5, 1.5), (0.3, 0.4, 0.5)
    two = add("mirrored", one.data, (0.6, 0.2, 0.6))
    two.scale, two.rotation_euler = (-1.0, 0.7, 1.2), (0.8, 0.1, 0.2)
    box = cube(material("BsdfAnisotropic", Color=(0.9, 0.9, 0.9), Roughness=0.4), (0.4, -1.0, 0.3))
    box.scale = (1.0, -0.6, 0.8)
    lamp("AREA", 80, size=1.5)
    sky((0.2, 0.2, 0.2))


lens = {"dof_use_dof": True, "dof_focus_distance": 4.5, "dof_aperture_fstop": 0.15}
gold = (0.95, 0.7, 0.3)
plain = partial(made_of, "BsdfPrincipled")

SCENES: dict[str, Callable[[], None]] = {
    "point": partial(lit_by, "POINT", 60, shadow_soft_size=0.0),
    "point-radius": partial(lit_by, "POINT", 60, shadow_soft_size=0.4, use_soft_falloff=False),
    "point-soft-falloff": partial(lit_by, "POINT", 60, shadow_soft_size=0.4, use_soft_falloff=True),
    "spot": partial(lit_by, "SPOT", 200, shadow_soft_size=0.0, spot_size=0.9, spot_blend=0.4),
    "spot-radius": partial(lit_by, "SPOT", 200, shadow_soft_size=0.3, spot_size=0.9, use_soft_falloff=False),
    "sun-sharp": partial(lit_by, "SUN", 3, angle=0.0),
    "sun-soft": partial(lit_by, "SUN", 3, angle=0.3),
    "area-square": partial(lit_by, "AREA", 60, shape="SQUARE", size=0.8),
    "area-rectangle": partial(lit_by, "AREA", 60, shape="RECTANGLE", size=1.5, size_y=0.3),
    "area-disk": partial(lit_by, "AREA", 60, shape="DISK", size=1.0),
    "area-ellipse": partial(lit_by, "AREA", 60, shape="ELLIPSE", size=1.5, size_y=0.5),
    "area-spread": partial(lit_by, "AREA", 60, shape="SQUARE", size=0.8, spread=math.radians(50)),
    "mesh-light": mesh_light,
    "environment-map": environment_map,
    "transparent-shadows": transparent_shadows,
    "image-texture": image_texture,
    "stretched": stretched,
    "oren-nayar": partial(made_of, "BsdfDiffuse", Color=(0.8, 0.5, 0.3), Roughness=0.9),
    "translucent": partial(made_of, "BsdfTranslucent", Color=(0.8, 0.5, 0.3)),
    "glossy-mirror": partial(made_of, "BsdfAnisotropic", Color=gold, Roughness=0.0),
    "glossy-ggx": partial(made_of, "BsdfAnisotropic", {"distribution": "GGX"}, Color=gold, Roughness=0.5),
    "glossy-multi": partial(
        made_of, "BsdfAnisotropic", {"distribution": "MULTI_GGX"}, Color=gold, Roughness=0.7
    ),
    "glossy-beckmann": partial(
        made_of, "BsdfAnisotropic", {"distribution": "BECKMANN"}, Color=gold, Roughness=0.5
    ),
    "glossy-anisotropic": partial(
        made_of, "BsdfAnisotropic", {"distribution": "GGX"}, Color=gold, Roughness=0.5, Anisotropy=0.7
    ),
    "metallic-f82": partial(made_of, "BsdfMetallic", Base_Color=gold, Roughness=0.4),
    "metallic-conductor": partial(
        made_of, "BsdfMetallic", {"fresnel_type": "PHYSICAL_CONDUCTOR"}, Roughness=0.3
    ),
    "glass-smooth": partial(made_of, "BsdfGlass", Color=(0.9, 1.0, 0.95), Roughness=0.0, IOR=1.5),
    "glass-rough": partial(made_of, "BsdfGlass", Color=(0.9, 1.0, 0.95), Roughness=0.4, IOR=1.5),
    "refraction-rough": partial(made_of, "BsdfRefraction", Color=(0.9, 1.0, 0.95), Roughness=0.3, IOR=1.3),
    "principled": partial(plain, Base_Color=(0.8, 0.3, 0.2)),
    "principled-smooth": partial(plain, Base_Color=(0.8, 0.3, 0.2), Roughness=0.1),
    "principled-metal": partial(plain, Base_Color=gold, Metallic=1.0, Roughness=0.35),
    "principled-half-metal": partial(plain, Base_Color=gold, Metallic=0.5, Roughness=0.6),
    "principled-coat": partial(plain, Base_Color=(0.1, 0.2, 0.7), Coat_Weight=1.0, Coat_Roughness=0.1),
    "principled-sheen": partial(plain, Base_Color=(0.1, 0.1, 0.1), Sheen_Weight=1.0, Sheen_Roughness=0.4),
    "principled-glass": partial(plain, Base_Color=(0.9, 0.95, 1.0), Transmission_Weight=1.0, Roughness=0.2),
    "principled-alpha": partial(plain, Base_Color=(0.8, 0.3, 0.2), Alpha=0.4),
    "principled-emission": partial(plain, Emission_Color=(1.0, 0.5, 0.1), Emission_Strength=2.0),
    "camera-ortho": partial(with_camera, set_to(type="ORTHO", ortho_scale=5.0)),
    "camera-shift": partial(with_camera, set_to(shift_x=0.2, shift_y=-0.1)),
    "camera-vertical-fit": partial(with_camera, set_to(sensor_fit="VERTICAL", sensor_height=20.0)),
    "camera-lens": partial(with_camera, set_to(**lens)),
    "camera-blades": partial(
        with_camera, set_to(**lens, dof_aperture_blades=5, dof_aperture_ratio=2.0, dof_aperture_rotation=0.4)
    ),
    "panorama": partial(panorama, "EQUIRECTANGULAR", longitude_min=-2.0, latitude_max=1.0),
    "fisheye-equidistant": partial(panorama, "FISHEYE_EQUIDISTANT", fisheye_fov=2.5),
    "fisheye-equisolid": partial(panorama, "FISHEYE_EQUISOLID", fisheye_fov=3.0, fisheye_lens=15.0),
    "fisheye-vertical-fit": partial(
        panorama, "FISHEYE_EQUISOLID", fisheye_fov=6.0, fisheye_lens=15.0, sensor_fit="VERTICAL"
    ),
    "fisheye-horizontal-fit": partial(
        panorama, "FISHEYE_EQUISOLID", fisheye_fov=6.0, fisheye_lens=15.0, sensor_fit="HORIZONTAL"
    ),
    "camera-ortho-lens": partial(
        with_camera, set_to(type="ORTHO", ortho_scale=5.0, **{**lens, "dof_aperture_fstop": 2.0})
    ),
}
