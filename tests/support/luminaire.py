"""A lamp that shines as an IES file says."""

import bpy

IES = "IESNA\nTILT=NONE\n1 1000 1 5 5 1 1 0 0 0 1 1 50\n0 30 60 120 180\n0 90 180 270 360\n" + "\n".join(
    " ".join(str((3 * i + 5 * j) % 7 + 1) for j in range(5)) for i in range(5)
)


def luminaire(tree, emission):
    """Its strength, in a lamp's tree."""
    node = tree.nodes.new("ShaderNodeTexIES")
    node.mode, node.ies = "INTERNAL", bpy.data.texts.new("ies")
    node.ies.write(IES)
    tree.links.new(node.outputs[0], emission.inputs["Strength"])
