"""Reads the point clouds that Blender imports from USD. Arguments: the stage, the .npz to write, times."""

import sys

import bpy
import numpy as np

KINDS = {
    "FLOAT": ("value", 1, np.float32),
    "INT": ("value", 1, np.int32),
    "FLOAT_VECTOR": ("vector", 3, np.float32),
    "FLOAT_COLOR": ("color", 4, np.float32),
    "QUATERNION": ("value", 4, np.float32),
}

bpy.ops.wm.read_factory_settings(use_empty=True)
bpy.ops.wm.usd_import(filepath=sys.argv[1])
found = {}
scene = bpy.context.scene
for time in map(float, sys.argv[3:]):
    scene.frame_set(int(time), subframe=time - int(time))
    graph = bpy.context.evaluated_depsgraph_get()
    for thing in bpy.data.objects:
        if thing.type != "POINTCLOUD":
            continue
        # Names of objects get numbers where two are equal; those of their data are the prims' names.
        cloud = thing.evaluated_get(graph).data
        name = thing.data.name
        count = len(cloud.points)
        found[f"{name}|{time}|count"] = np.array(count)
        for attribute in cloud.attributes:
            field, width, kind = KINDS[attribute.data_type]
            values = np.empty(count * width, kind)
            if count:
                attribute.data.foreach_get(field, values)
            found[f"{name}|{time}|{attribute.name}"] = values.reshape(count, width)
np.savez(sys.argv[2], **found)
