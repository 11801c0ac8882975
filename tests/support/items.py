"""What a .blend holds besides materials, item by item: small scenes for Cycles and for us.

Each maker makes the current Blender file; most are those of the tests.
"""

from collections.abc import Callable
from functools import partial

import bpy
from reference import own_scenes
from support import moving_room, seen_room, skies, terminators, tufts
from support.bpy_nodes import with_nodes
from support.bpy_scenes import add, empty_scene, mesh
from support.instancers import grid, on_points
from support.luminaire import luminaire

GREY, CLAY = (0.6, 0.6, 0.6, 1), (0.8, 0.5, 0.3, 1)
LENS = {"dof_use_dof": True, "dof_focus_distance": 4.5, "dof_aperture_fstop": 0.15}
BLADES = {"dof_aperture_blades": 5, "dof_aperture_ratio": 2.0, "dof_aperture_rotation": 0.4}


def in_motion(build, blurred=True):
    """A scene of `moving_room` at frame 2, the shutter open or not."""
    scene = moving_room.stage()
    build(scene)
    scene.frame_set(2)
    scene.render.use_motion_blur = blurred


def rolling(scene):
    """Each row of pixels has its own part of the shutter's time."""
    scene.cycles.rolling_shutter_type, scene.cycles.rolling_shutter_duration = "TOP", 0.2
    moving_room.moving_box(scene)


def faces_that_instance():
    """A box on each face of a grid."""
    moving_room.stage().render.use_motion_blur = False
    faces = grid("Faces", (0, 0, 0.6), instance_type="FACES")
    faces.show_instancer_for_render = False
    moving_room.box("Small", 0.5).parent = faces


def nodes_that_instance():
    """Boxes on the points of a grid, each painted by an attribute of its own."""
    moving_room.stage().render.use_motion_blur = False
    template = moving_room.box("Template", 0.4)
    template.location = (0, 50, 0)
    tree = template.data.materials[0].node_tree
    paint = tree.nodes.new("ShaderNodeAttribute")
    paint.attribute_name, paint.attribute_type = "tint", "INSTANCER"
    info, mixed = tree.nodes.new("ShaderNodeObjectInfo"), tree.nodes.new("ShaderNodeMixRGB")
    tree.links.new(info.outputs["Random"], mixed.inputs["Fac"])
    tree.links.new(paint.outputs["Color"], mixed.inputs["Color1"])
    tree.links.new(mixed.outputs[0], tree.nodes["Diffuse BSDF"].inputs["Color"])
    on_points(grid("Points", (0, 0, 0.6)), template, True)


def strands(shape):
    """Hair curves."""
    tufts.hair(tufts.sunny(), tufts.shaded("BsdfDiffuse", Color=CLAY), shape)


def one_of(make):
    """A thick curve."""
    make(tufts.sunny(), tufts.shaded("BsdfDiffuse", Color=CLAY), "THICK")


def strands_of_particles():
    """Hair particles with children."""
    tufts.emitter(tufts.sunny(), tufts.shaded("BsdfDiffuse", Color=CLAY), "INTERPOLATED")


def points():
    """A point cloud."""
    tufts.cloud(tufts.sunny(), tufts.shaded("BsdfDiffuse", Color=CLAY))


def diced():
    """A square, diced to the camera's pixels and displaced by noise."""
    scene = tufts.sunny()
    made = tufts.shaded("BsdfDiffuse", Color=CLAY)
    made.displacement_method = "DISPLACEMENT"
    tree = made.node_tree
    noise, step = tree.nodes.new("ShaderNodeTexNoise"), tree.nodes.new("ShaderNodeDisplacement")
    noise.inputs["Scale"].default_value, step.inputs["Scale"].default_value = 3.0, 0.3
    tree.links.new(noise.outputs[0], step.inputs["Height"])
    tree.links.new(step.outputs[0], tree.nodes["Material Output"].inputs["Displacement"])
    data = mesh([(-1, -1, 0), (1, -1, 0), (1, 1, 0), (-1, 1, 0)], [(0, 1, 2, 3)], "Square")
    data.materials.append(made)
    owner = add(data, "Square", location=(0, 0, 0.2), rotation_euler=(0.5, 0, 0.3))
    modifier = owner.modifiers.new("Subdivision", "SUBSURF")
    modifier.subdivision_type, modifier.levels = "SIMPLE", 1
    if hasattr(modifier, "use_adaptive_subdivision"):
        modifier.use_adaptive_subdivision = True
    else:
        owner.cycles.use_adaptive_subdivision, scene.cycles.feature_set = True, "EXPERIMENTAL"


def bent_normals():
    """A flat square whose normals say that it is round."""
    tufts.sunny()
    data = mesh([(-1, 0, 0), (1, 0, 0), (1, 0, 1.2), (-1, 0, 1.2)], [(0, 1, 2, 3)], "Square")
    data.normals_split_custom_set([(x, -0.8, z) for x, z in ((-1, -1), (1, -1), (1, 1), (-1, 1))])
    data.materials.append(tufts.shaded("BsdfDiffuse", Color=CLAY))
    add(data, "Square", rotation_euler=(-0.2, 0, 0.2))


def lamp_with(build, kind, power, **settings):
    """A lamp whose nodes `build` makes."""
    own_scenes.lit_by(kind, power, **settings)
    tree = with_nodes(bpy.data.lights["lamp"])
    emission, out = (tree.nodes.new("ShaderNode" + name) for name in ("Emission", "OutputLight"))
    tree.links.new(emission.outputs[0], out.inputs["Surface"])
    build(tree, emission)


def painted(tree, emission):
    """Stripes across the lamp."""
    place, waves = tree.nodes.new("ShaderNodeTexCoord"), tree.nodes.new("ShaderNodeTexWave")
    tree.links.new(place.outputs["UV"], waves.inputs["Vector"])
    tree.links.new(waves.outputs["Color"], emission.inputs["Color"])


def fading(tree, emission):
    """Strength that falls with the distance."""
    node = tree.nodes.new("ShaderNodeLightFalloff")
    node.inputs["Strength"].default_value = 1.5
    tree.links.new(node.outputs["Linear"], emission.inputs["Strength"])


def outdoors(**settings):
    """A box under a Sky Texture."""
    scene = empty_scene()
    skies.sky(scene, **settings)
    skies.box_outdoors(scene)


def node_made_world():
    """A world of noise with bright spots."""
    own_scenes.empty()
    own_scenes.floor()
    own_scenes.ball(own_scenes.material("BsdfDiffuse", Color=(0.7, 0.7, 0.7)))
    background = own_scenes.sky((0, 0, 0))
    tree = bpy.context.scene.world.node_tree
    noise, steep = tree.nodes.new("ShaderNodeTexNoise"), tree.nodes.new("ShaderNodeMath")
    noise.inputs["Scale"].default_value = 3.0
    steep.operation, steep.inputs[1].default_value = "POWER", 8.0
    tree.links.new(noise.outputs["Fac"], steep.inputs[0])
    tree.links.new(steep.outputs[0], background.inputs["Strength"])
    background.inputs["Color"].default_value = (40, 50, 60, 1)


def seen_by(change):
    """A change of `seen_room`."""
    change(seen_room.room())


def glass_before_the_sky():
    """A pane through which nothing but the transparent film is seen."""
    seen_room.clear_film(roughness=0.1)(seen_room.room())
    seen_room.of("Glass").location.z = 2.2


def border(crop):
    """A part of the picture."""
    own_scenes.with_camera(own_scenes.set_to())
    render = bpy.context.scene.render
    render.use_border, render.use_crop_to_border = True, crop
    render.border_min_x, render.border_max_x = 0.25, 0.8
    render.border_min_y, render.border_max_y = 0.1, 0.7


def two_eyes(**settings):
    """A stereoscopic pair."""
    own_scenes.with_camera(own_scenes.set_to())
    scene = bpy.context.scene
    scene.render.use_multiview = True
    scene.render.image_settings.views_format = "INDIVIDUAL"
    stereo = scene.camera.data.stereo
    stereo.interocular_distance, stereo.convergence_distance = 0.8, 2.5
    for name, value in settings.items():
        setattr(stereo, name, value)


def view(**settings):
    """A camera with some settings."""
    return partial(own_scenes.with_camera, own_scenes.set_to(**settings))


own, room, panorama = own_scenes.SCENES, seen_room.CASES, own_scenes.panorama

ITEMS: dict[str, dict[str, Callable[[], None]]] = {
    "Geometry": {
        "instances of a collection": partial(in_motion, moving_room.turning_collection, False),
        "instances of particles": partial(in_motion, moving_room.particles, False),
        "instances of geometry nodes, with attributes": nodes_that_instance,
        "instances on faces": faces_that_instance,
        "uneven and negative scales": own["stretched"],
        "hair as ribbons": partial(strands, "RIBBONS"),
        "hair as round tubes": partial(strands, "THICK"),
        "hair as straight tubes": partial(strands, "THICK_LINEAR"),
        "a coil": partial(one_of, tufts.coil),
        "a tube seen from its end": partial(one_of, tufts.tube),
        "hair particles with children": strands_of_particles,
        "point cloud": points,
        "adaptive subdivision and displacement": diced,
        "custom normals": bent_normals,
        "shadow terminator, point lamp": partial(terminators.build, "ball", "POINT"),
        "shadow terminator, area lamp": partial(terminators.build, "cone", "AREA", 1.0),
    },
    "Motion": {
        "objects that move, turn and grow": partial(in_motion, moving_room.moving_box),
        "the camera": partial(in_motion, moving_room.moving_camera),
        "rolling shutter": partial(in_motion, rolling),
        "deformation, shutter curve": partial(in_motion, moving_room.changing_shape),
        "a mesh, by geometry nodes": partial(in_motion, moving_room.shaped_by_nodes),
        "a mesh, by its velocities": partial(in_motion, partial(moving_room.shaped_by_nodes, by="velocity")),
        "a point cloud": partial(in_motion, moving_room.moving_cloud),
        "points, by geometry nodes": partial(in_motion, partial(moving_room.shaped_by_nodes, points=True)),
        "points, by their velocities": partial(
            in_motion, partial(moving_room.shaped_by_nodes, by="velocity", points=True)
        ),
        "instances of a collection": partial(in_motion, moving_room.turning_collection),
        "instances of geometry nodes": partial(in_motion, moving_room.moving_nodes),
        "particles": partial(in_motion, moving_room.particles),
        "lamps and a mesh light": partial(in_motion, moving_room.moving_lights),
    },
    "Lights": {
        **{name.replace("-", ", "): own[name] for name in own if name.startswith(("point", "spot", "sun"))},
        **{name.replace("-", ", "): own[name] for name in own if name.startswith("area")},
        "mesh lights": own["mesh-light"],
        "nodes: texture on an area lamp": partial(lamp_with, painted, "AREA", 60, size=1.0),
        "nodes: light falloff": partial(lamp_with, fading, "POINT", 20, shadow_soft_size=0.2),
        "IES": partial(lamp_with, luminaire, "POINT", 20, shadow_soft_size=0.1),
        **{
            name: partial(seen_by, room[name])
            for name in (
                "portal",
                "sun for 0 bounces",
                "sun for 1 bounces",
                "shining cube not sampled",
                "lamp on cube and mirror",
                "lamp not on floor",
                "many lamps on some",
                "lamp not shaded by cube",
                "lamp shaded by box alone",
            )
        },
    },
    "Who sees whom": {
        name: partial(seen_by, room[name])
        for name in (
            "cube unseen by camera",
            "cube unseen by diffuse",
            "cube unseen by glossy",
            "cube unseen by transmission",
            "cube unseen by shadow",
            "lamp unseen by glossy",
            "world unseen by diffuse",
            "cube held out",
            "collection held out",
            "collection for indirect light only",
            "floor catches shadows",
            "floor catches shadows on a clear film",
            "one material",
            "another world",
            "clear film",
            "clear film behind rough glass",
        )
    }
    | {"clear film behind glass": glass_before_the_sky},
    "Environment": {
        "image with a small sun": own["environment-map"],
        "made by nodes": node_made_world,
        "sky, single scattering, with its sun": partial(
            outdoors, sky_type="SINGLE_SCATTERING", sun_elevation=0.5, sun_rotation=2.0
        ),
        "sky, multiple scattering, with its sun": partial(
            outdoors, sky_type="MULTIPLE_SCATTERING", sun_elevation=0.5, sun_rotation=2.0
        ),
        "sky, Preetham": partial(outdoors, sky_type="PREETHAM", turbidity=3.0),
        "sky, Hosek and Wilkie": partial(outdoors, sky_type="HOSEK_WILKIE", turbidity=3.0),
    },
    "Cameras": {
        "parallel": view(type="ORTHO", ortho_scale=5.0),
        "shifted": view(shift_x=0.2, shift_y=-0.1),
        "depth of field": view(**LENS),
        "blades, ratio and rotation": view(**LENS, **BLADES),
        "parallel, depth of field": view(
            type="ORTHO", ortho_scale=5.0, **{**LENS, "dof_aperture_fstop": 2.0}
        ),
        "equirectangular": partial(panorama, "EQUIRECTANGULAR", longitude_min=-2.0, latitude_max=1.0),
        "cube face": partial(panorama, "EQUIANGULAR_CUBEMAP_FACE"),
        "mirror ball": partial(panorama, "MIRRORBALL"),
        "fisheye, equidistant": partial(panorama, "FISHEYE_EQUIDISTANT", fisheye_fov=2.5),
        "fisheye, equisolid": partial(panorama, "FISHEYE_EQUISOLID", fisheye_fov=3.0, fisheye_lens=15.0),
        "fisheye, lens polynomial": partial(panorama, "FISHEYE_LENS_POLYNOMIAL"),
        "cylinder": partial(panorama, "CENTRAL_CYLINDRICAL"),
        "stereo, off-axis": two_eyes,
        "stereo, toed in": partial(two_eyes, convergence_mode="TOE"),
        "stereo, spherical": partial(two_eyes, convergence_mode="TOE", use_spherical_stereo=True),
        "border": partial(border, False),
        "border, cropped": partial(border, True),
    },
}
