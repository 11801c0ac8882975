"""Hair and point clouds against Cycles: small files made here, each image z-tested.

1 % of the image's mean is allowed beyond the noise: ribbons' pieces are not cut at the same places.
Hair BSDF only toward a sun without bounces: under a sky Cycles' sampler adds light (see
`nodes.hair`).
"""

import pytest

bpy = pytest.importorskip("bpy")
from support.cycles import by_cycles, by_engine  # noqa: E402
from support.tufts import background, cloud, coil, emitter, hair, shaded, shining, sunny, tube  # noqa: E402
from support.ztest import compare  # noqa: E402

SIZE = (40, 40)


@pytest.fixture(name="scene")
def _scene():
    return sunny()


def slow(*values, **more):
    """A case left out where CI repeats the suite."""
    return pytest.param(*values, marks=pytest.mark.slow, **more)


def agree(tmp_path, samples, tolerance=0.01, cycles=None, **ours):
    """Both renderers on the current file."""
    theirs = by_cycles(samples, SIZE, tmp_path, **(cycles or {}))
    found = compare(by_engine(samples, SIZE, **ours), theirs)
    assert found.agrees(tolerance), str(found)


@pytest.mark.parametrize("shape", ["RIBBONS", "THICK", slow("THICK_LINEAR")])
def test_curves(shape, scene, tmp_path):
    hair(scene, shaded("BsdfDiffuse", Color=(0.8, 0.5, 0.3, 1)), shape)
    agree(tmp_path, 12)


@pytest.mark.parametrize("shape", ["RIBBONS", slow("THICK")])
def test_principled_hair(shape, scene, tmp_path):
    hair(scene, shaded("BsdfHairPrincipled", {"model": "CHIANG"}, Color=(0.5, 0.3, 0.1, 1)), shape)
    agree(tmp_path, 12)


@pytest.mark.parametrize("shape", ["THICK", slow("THICK_LINEAR")])
def test_a_coil_does_not_shade_itself(shape, scene, tmp_path):
    """Rays do not meet the curve that they start on: 4 % of the picture, half a per cent is allowed."""
    coil(scene, shaded("BsdfDiffuse"), shape)
    agree(tmp_path, 24, 0.005)


@pytest.mark.parametrize("shape", ["THICK", slow("THICK_LINEAR")])
def test_a_tube_seen_from_its_end(shape, scene, tmp_path):
    """Its inner wall, or the ball that closes it."""
    tube(scene, shaded("BsdfDiffuse"), shape)
    agree(tmp_path, 24, 0.005)


@pytest.mark.parametrize(
    ("aspect", "light", "color"),
    [
        (1.0, "sky", (0.5, 0.3, 0.1, 1)),
        slow(0.5, "sky", (0.5, 0.3, 0.1, 1)),
        slow(1.0, "sun", (0.001, 0.001, 0.001, 1)),
    ],
)
def test_principled_hair_of_facets(aspect, light, color, scene, tmp_path):
    """Toward a sun only black hair: what is reflected inside more than twice Cycles' evaluation lacks."""
    made = shaded("BsdfHairPrincipled", {"model": "HUANG"}, Color=color, Aspect_Ratio=aspect, Offset=0.0)
    hair(scene, made, "RIBBONS")
    if light == "sky":
        bpy.data.lights["Sun"].energy = 0
    else:
        background(scene).inputs["Strength"].default_value = 0
    agree(tmp_path, 24, 0.01)


@pytest.mark.parametrize("component", ["Reflection", slow("Transmission")])
@pytest.mark.parametrize("shape", ["RIBBONS", slow("THICK")])
def test_hair_lobes_toward_a_sun(shape, component, scene, tmp_path):
    """To 6 %: few pixels of a narrow lobe about a tangent are lit at all."""
    hair(scene, shaded("BsdfHair", {"component": component}, Offset=0.1), shape)
    background(scene).inputs["Strength"].default_value = 0
    bpy.data.lights["Sun"].angle = 0
    agree(tmp_path, 16, 0.06, {"max_bounces": 0}, max_depth=2)


@pytest.mark.parametrize(
    ("shape", "kind", "outputs", "more"),
    [
        ("RIBBONS", "HairInfo", ("Is Strand", "Intercept", "Length"), {}),
        slow("RIBBONS", "HairInfo", ("Random", "Thickness", "Length"), {"scale": (1, 10, 1)}),
        slow("RIBBONS", "HairInfo", ("Tangent Normal",), {}),
        slow("RIBBONS", "NewGeometry", ("Normal",), {}),
        ("THICK", "NewGeometry", ("Normal",), {}),
        slow("RIBBONS", "NewGeometry", ("True Normal",), {}),
        slow("THICK", "NewGeometry", ("True Normal",), {}),
        slow("RIBBONS", "NewGeometry", ("Tangent",), {}),
        slow("THICK", "NewGeometry", ("Tangent",), {}),
        slow("RIBBONS", "TexCoord", ("Generated",), {}),
        slow("RIBBONS", "TexCoord", ("UV",), {}),
        slow("RIBBONS", "Attribute", ("Color",), {"settings": {"attribute_name": "by point"}}),
        slow("RIBBONS", "Attribute", ("Color",), {"settings": {"attribute_name": "by curve"}}),
    ],
)
def test_what_strands_know(shape, kind, outputs, more, scene, tmp_path):
    hair(scene, shining(kind, *outputs, **more), shape)
    agree(tmp_path, 8)


@pytest.mark.parametrize("child_type", [slow("NONE"), "INTERPOLATED"])
def test_particle_strands(child_type, scene, tmp_path):
    """Children and parents, tapering, the second material slot, on a scaled emitter."""
    emitter(scene, shaded("BsdfDiffuse", Color=(0.8, 0.5, 0.3, 1)), child_type)
    agree(tmp_path, 12)


@pytest.mark.slow
def test_what_particle_strands_know(scene, tmp_path):
    emitter(scene, shining("HairInfo", "Intercept", "Random", "Thickness", scale=(1, 1, 5)))
    agree(tmp_path, 8)


@pytest.mark.slow
@pytest.mark.parametrize("output", ["UV", "Generated"])
def test_where_particle_strands_stand(output, scene, tmp_path):
    emitter(scene, shining("TexCoord", output))
    agree(tmp_path, 8)


@pytest.mark.parametrize(
    "material",
    [
        lambda: shaded("BsdfDiffuse", Color=(0.8, 0.5, 0.3, 1)),
        slow(lambda: shining("PointInfo", "Position")),
        slow(lambda: shining("PointInfo", "Radius", "Random", "Radius", scale=(5, 1, 5))),
        slow(lambda: shining("Attribute", "Color", settings={"attribute_name": "paint"})),
    ],
    ids=["diffuse", "position", "numbers", "attribute"],
)
def test_point_clouds(material, scene, tmp_path):
    cloud(scene, material())
    agree(tmp_path, 8)


def test_instances_of_curves(scene, tmp_path):
    """A collection of a tuft placed twice, turned, scaled evenly and mirrored."""
    tuft = hair(scene, shaded("BsdfDiffuse", Color=(0.8, 0.5, 0.3, 1)), "RIBBONS")
    collection = bpy.data.collections.new("Tufts")
    scene.collection.objects.unlink(tuft)
    collection.objects.link(tuft)
    for place, turn, size in (
        ((-0.5, 0, 0), 0.5, (0.5, 0.5, 0.5)),
        ((0.5, 0.3, 0.2), -0.5, (-0.7, 0.7, 0.7)),
    ):
        empty = bpy.data.objects.new("Place", None)
        empty.instance_type, empty.instance_collection = "COLLECTION", collection
        empty.location, empty.rotation_euler, empty.scale = place, (0, turn, 0), size
        scene.collection.objects.link(empty)
    agree(tmp_path, 8)


@pytest.mark.slow
@pytest.mark.parametrize("name", ["catcher", "holdout", "no camera", "no shadow"])
def test_curves_seen_otherwise(name, scene, tmp_path):
    """A tuft above a floor that catches its shadow, one that cuts a hole, or that some rays don't see.

    To 2 %: what blocks no shadow rays still blocks scattered ones, so the sky counts by the weights of both,
    which are not Cycles'.
    """
    tuft = hair(scene, shaded("BsdfDiffuse", Color=(0.8, 0.5, 0.3, 1)), "THICK_LINEAR", 0.06)
    bpy.ops.mesh.primitive_plane_add(size=4)
    floor = bpy.context.object
    floor.data.materials.append(shaded("BsdfDiffuse", Color=(0.6, 0.6, 0.6, 1)))
    floor.is_shadow_catcher, tuft.is_holdout = name == "catcher", name == "holdout"
    tuft.visible_camera, tuft.visible_shadow = name != "no camera", name != "no shadow"
    scene.render.film_transparent = name in ("catcher", "holdout")
    agree(tmp_path, 12, 0.02)
