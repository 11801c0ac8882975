"""What an instance knows: its instancer's attributes and coordinates, its particle, its random number."""

import pytest

bpy = pytest.importorskip("bpy")
from support.bpy_scenes import add, cube  # noqa: E402
from support.instancers import grid, on_points  # noqa: E402
from support.seen_nodes import build, case, compare  # noqa: E402

EDGE = 0.06  # the instances are small: more of their pixels lie on edges
NUMBERS = ("Index", "Random", "Age", "Lifetime", "Size")
VECTORS = ("Location", "Velocity", "Angular Velocity")


@pytest.fixture(scope="module")
def stage():
    scene, tree = build()
    material = bpy.data.materials["Test"]
    material.pass_index = 5
    for name in ("Ball", "Box"):
        bpy.data.objects.remove(bpy.data.objects[name])
    small = cube("Small", 0.35)
    small.materials.append(material)
    faces = grid("Faces", (-1.3, 0, 1.0), instance_type="FACES", color=(0.3, 0.6, 0.1, 0.7))
    faces.show_instancer_for_render = faces.show_instancer_for_viewport = False
    faces["of instancer"] = 0.4
    add(small, "Child", pass_index=2, color=(0.2, 0.5, 0.7, 0.6)).parent = faces
    template = add(small, "Template", location=(0, 50, 0))
    template["of object"] = 0.7
    on_points(grid("Points", (1.3, 0, 1.0)), template, True)
    on_points(grid("Meshes", (-1.3, 0, -1.0)), template, False)
    collection = bpy.data.collections.new("Collection")
    collection.objects.link(template)
    empty = add(None, "Empty", location=(0, -50, 0.2), instance_type="COLLECTION", color=(0.9, 0.1, 0.4, 0.3))
    empty.instance_collection = collection
    emitter = grid("Emitter", (1.3, 0, -1.0))
    emitter.show_instancer_for_render = emitter.show_instancer_for_viewport = False
    emitter.modifiers.new("Particles", "PARTICLE_SYSTEM")
    system = emitter.particle_systems[0].settings
    system.count, system.frame_start, system.frame_end, system.lifetime = 12, 1, 4, 50
    system.normal_factor, system.factor_random, system.particle_size = 0.4, 0.2, 0.6
    system.render_type, system.instance_object, system.size_random = "OBJECT", template, 0.5
    system.use_rotations, system.angular_velocity_mode, system.angular_velocity_factor = True, "RAND", 1.0
    system["of settings"] = 0.9
    scene.frame_set(1)
    for frame in range(2, 7):
        scene.frame_set(frame)
    return scene, tree


def instancer(name, output="Color"):
    return case("Attribute", output, EDGE, attribute_name=name, attribute_type="INSTANCER")


CASES = [
    *(case("TexCoord", o, EDGE, from_instancer=True) for o in ("Generated", "UV", "Normal", "Object")),
    case("UVMap", "UV", EDGE, from_instancer=True),
    *(
        instancer(name)
        for name in ("of instancer", "of object", "of settings", "tint", "location", "missing")
    ),
    instancer("tint", "Alpha"),
    case("Attribute", "Color", EDGE, attribute_name="of object", attribute_type="OBJECT"),
    *(
        case("ObjectInfo", o, EDGE)
        for o in ("Location", "Color", "Alpha", "Object Index", "Material Index", "Random")
    ),
    *(case("ParticleInfo", o, EDGE) for o in (*NUMBERS, *VECTORS)),
    *(case("HairInfo", o) for o in ("Is Strand", "Intercept", "Thickness", "Tangent Normal", "Random")),
    *(case("PointInfo", o) for o in ("Position", "Radius", "Random")),
]


@pytest.mark.parametrize("c", CASES)
def test_instance_is_what_cycles_sees(c, stage):
    compare(*stage, c)
