"""Says where Blender's importer puts a shot, in pixels of its own camera.

Arguments: the stage, the .npz to write, frames. With a picture's name at the
end, Cycles draws the first frame.
"""

import sys

import bpy
import numpy as np

stage, target, *rest = sys.argv[1:]
picture = rest.pop() if rest[-1].endswith(".png") else ""
bpy.ops.wm.read_factory_settings(use_empty=True)
bpy.context.scene.world = bpy.data.worlds.new("World")  # where the sky goes
bpy.ops.wm.usd_import(filepath=stage)
scene = bpy.context.scene
camera = next(thing for thing in bpy.data.objects if thing.type == "CAMERA")
scene.camera = camera
scene.render.resolution_x, scene.render.resolution_y = 480, 270
found = {}


def matrix(thing):
    return np.array(thing.matrix_world)


def pixels(points, graph):
    """Return where points in the world are in the picture, px from the top left."""
    own = camera.evaluated_get(graph)
    wide, high = scene.render.resolution_x, scene.render.resolution_y
    lens = np.array(own.calc_matrix_camera(graph, x=wide, y=high)) @ np.linalg.inv(matrix(own))
    at = np.column_stack([points, np.ones(len(points))]) @ lens.T
    at = at[:, :2] / at[:, 3:]
    return np.column_stack([(at[:, 0] + 1) / 2 * wide, (1 - at[:, 1]) / 2 * high])


def vertices(mesh):
    points = np.empty(3 * len(mesh.vertices), np.float32)
    mesh.vertices.foreach_get("co", points)
    return points.reshape(-1, 3)


for frame in map(int, rest):
    scene.frame_set(frame)
    graph = bpy.context.evaluated_depsgraph_get()
    counts = {}
    for instance in graph.object_instances:
        thing = instance.object
        name = thing.original.data.name if thing.original.data else thing.name
        name = instance.parent.original.name + "/" + name if instance.is_instance else name
        if thing.type == "MESH":
            points = vertices(thing.data)
        elif thing.type == "POINTCLOUD":
            points = np.empty(3 * len(thing.data.points), np.float32)
            thing.data.points.foreach_get("co", points)
            points = points.reshape(-1, 3)
        elif thing.type == "CURVES":
            points = np.empty(3 * len(thing.data.points), np.float32)
            thing.data.points.foreach_get("position", points)
            points = points.reshape(-1, 3)
        else:
            continue
        if not instance.is_instance and (thing.hide_render or thing.original.hide_render):
            continue
        place = np.array(instance.matrix_world)
        world = points @ place[:3, :3].T + place[:3, 3]
        number = counts[name] = counts.get(name, 0) + 1
        found[f"{frame}|{name}|{number}"] = pixels(world, graph) if len(world) else world[:, :2]
np.savez(target, **found)
if picture:
    scene.frame_set(int(rest[0]))
    for light in bpy.data.lights:
        if light.type == "SUN":
            light.energy /= 4  # the importer of Blender 5.0 makes a sun of USD four times as bright
    scene.render.engine = "CYCLES"
    scene.cycles.samples = 24
    scene.cycles.device = "CPU"
    scene.view_settings.view_transform = "Standard"
    scene.render.filepath = picture
    bpy.ops.render.render(write_still=True)
