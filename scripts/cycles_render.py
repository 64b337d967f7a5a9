"""Renders a scene that Cousin wrote with Blender's Cycles on the CPU.

Called as: blender -b --factory-startup -noaudio -P cycles_render.py -- FOLDER
FOLDER/scene.json describes the scene; arrays are raw little-endian files beside it. Each run of
scene.json's "runs" becomes FOLDER/run_N.exr; seconds go to FOLDER/times.json. With "blend" or
"gltf" the scene is saved under those names and, without runs, nothing is rendered.
"""

import json
import math
import os
import sys
import time

import bpy
import mathutils
import numpy as np

FOLDER = sys.argv[sys.argv.index("--") + 1]


def array(name, dtype, columns):
    return np.fromfile(os.path.join(FOLDER, name), dtype=dtype).reshape(-1, columns)


def make_mesh(model):
    vertices = array(model["vertices"], "<f4", 3)
    triangles = array(model["triangles"], "<u4", 3).astype(np.int32)
    mesh = bpy.data.meshes.new(model["name"])
    mesh.vertices.add(len(vertices))
    mesh.vertices.foreach_set("co", vertices.ravel())
    mesh.loops.add(triangles.size)
    mesh.loops.foreach_set("vertex_index", triangles.ravel())
    mesh.polygons.add(len(triangles))
    mesh.polygons.foreach_set("loop_start", np.arange(0, triangles.size, 3, dtype=np.int32))
    mesh.polygons.foreach_set("loop_total", np.full(len(triangles), 3, dtype=np.int32))
    smooth = "normals" in model
    mesh.polygons.foreach_set("use_smooth", np.full(len(triangles), smooth))
    if "albedo" in model:
        colors = array(model["albedo"], "<f4", 3)
        layer = mesh.attributes.new("albedo", "FLOAT_COLOR", "POINT")
        layer.data.foreach_set("color", np.hstack([colors, np.ones((len(colors), 1), "f4")]).ravel())
    mesh.update()
    if smooth:
        mesh.use_auto_smooth = True
        mesh.normals_split_custom_set_from_vertices(array(model["normals"], "<f4", 3))
    return mesh


def flesh(nodes, spec):
    """Random walks. Blender's mean free path is radius / (4 pi) * (1.9 - A + 3.5 (A - 0.8)^2)."""
    shader = nodes.new("ShaderNodeSubsurfaceScattering")
    shader.falloff = "RANDOM_WALK_FIXED_RADIUS"
    shader.inputs["Scale"].default_value = 1
    shader.inputs["Radius"].default_value = [
        4 * math.pi * path / (1.9 - a + 3.5 * (a - 0.8) ** 2)
        for path, a in zip(spec["mean_free_path_m"], spec["albedo"])]
    return shader


def make_material(spec):
    material = bpy.data.materials.new(spec["name"] or "material")
    material.use_nodes = True
    nodes, links = material.node_tree.nodes, material.node_tree.links
    nodes.clear()
    output = nodes.new("ShaderNodeOutputMaterial")

    def color(rgb):
        node = nodes.new("ShaderNodeRGB")
        node.outputs[0].default_value = (*rgb, 1)
        if not spec["vertex_albedo"]:
            return node.outputs[0]
        attribute = nodes.new("ShaderNodeAttribute")
        attribute.attribute_name = "albedo"
        mix = nodes.new("ShaderNodeMixRGB")
        mix.blend_type = "MULTIPLY"
        mix.inputs["Fac"].default_value = 1
        links.new(node.outputs[0], mix.inputs["Color1"])
        links.new(attribute.outputs["Color"], mix.inputs["Color2"])
        return mix.outputs[0]

    kind = spec["kind"]
    if kind == "conductor":
        shader = nodes.new("ShaderNodeBsdfGlossy")
        shader.distribution = "MULTI_GGX"
        shader.inputs["Roughness"].default_value = spec["roughness"]
        links.new(color(spec["albedo"]), shader.inputs["Color"])
    elif kind in ("glass", "clear"):
        shader = nodes.new("ShaderNodeBsdfGlass")
        shader.distribution = "SHARP" if kind == "clear" else "MULTI_GGX"
        shader.inputs["Roughness"].default_value = 0 if kind == "clear" else spec["roughness"]
        shader.inputs["IOR"].default_value = spec["ior"]
        links.new(color(spec["albedo"]), shader.inputs["Color"])
    else:
        if max(spec["mean_free_path_m"]) > 0:
            shader = flesh(nodes, spec)
        else:
            shader = nodes.new("ShaderNodeBsdfDiffuse")
        links.new(color(spec["albedo"]), shader.inputs["Color"])
        if kind == "leaf":
            through = nodes.new("ShaderNodeBsdfTranslucent")
            through.inputs["Color"].default_value = (*spec["transmittance"], 1)
            both = nodes.new("ShaderNodeAddShader")
            links.new(shader.outputs[0], both.inputs[0])
            links.new(through.outputs[0], both.inputs[1])
            shader = both
        if spec["ior"] > 1:
            # Nearest that Cycles has: a GGX coat mixed over the base by Fresnel's share.
            coat = nodes.new("ShaderNodeBsdfGlossy")
            coat.distribution = "GGX"
            coat.inputs["Roughness"].default_value = spec["roughness"]
            fresnel = nodes.new("ShaderNodeFresnel")
            fresnel.inputs["IOR"].default_value = spec["ior"]
            mix = nodes.new("ShaderNodeMixShader")
            links.new(fresnel.outputs[0], mix.inputs["Fac"])
            links.new(shader.outputs[0], mix.inputs[1])
            links.new(coat.outputs[0], mix.inputs[2])
            shader = mix
    links.new(shader.outputs[0], output.inputs["Surface"])
    return material


def matrix(rows):
    return mathutils.Matrix([rows[0:4], rows[4:8], rows[8:12], rows[12:16]])


def add_lights(scene, spec):
    for sun in spec["suns"]:
        light = bpy.data.lights.new("sun", "SUN")
        brightest = max(max(sun["irradiance"]), 1e-30)
        light.energy = brightest
        light.color = [c / brightest for c in sun["irradiance"]]
        light.angle = 2 * sun["angular_radius_rad"]
        light.cycles.max_bounces = 1024
        thing = bpy.data.objects.new("sun", light)
        direction = mathutils.Vector(sun["to_sun"])
        thing.rotation_mode = "QUATERNION"
        thing.rotation_quaternion = direction.to_track_quat("Z", "Y")
        scene.collection.objects.link(thing)
    for lamp in spec["lamps"]:
        u, v = mathutils.Vector(lamp["axis_u_m"]), mathutils.Vector(lamp["axis_v_m"])
        light = bpy.data.lights.new("lamp", "AREA")
        light.shape = "RECTANGLE"
        light.size, light.size_y = 2 * u.length, 2 * v.length
        brightest = max(max(lamp["radiance"]), 1e-30)
        # Blender's radiance is power / (4 area), measured: a Lambertian face would have pi there.
        light.energy = brightest * 4 * light.size * light.size_y
        light.color = [c / brightest for c in lamp["radiance"]]
        light.cycles.max_bounces = 1024
        # A lamp shines along its -z.
        z = -u.cross(v).normalized()
        x = u.normalized()
        rotation = mathutils.Matrix([x, z.cross(x), z]).transposed().to_4x4()
        thing = bpy.data.objects.new("lamp", light)
        thing.matrix_world = mathutils.Matrix.Translation(lamp["centre_in_world_m"]) @ rotation
        scene.collection.objects.link(thing)
    world = bpy.data.worlds.new("sky")
    scene.world = world
    world.use_nodes = True
    nodes, links = world.node_tree.nodes, world.node_tree.links
    background = nodes["Background"]
    if spec["sky"] is None:
        background.inputs["Color"].default_value = (0, 0, 0, 1)
        return
    sky = spec["sky"]
    picture = bpy.data.images.new("sky", sky["width_px"], sky["height_px"], float_buffer=True)
    picture.colorspace_settings.name = "Linear"
    pixels = array(sky["pixels"], "<f4", 3)
    picture.pixels.foreach_set(np.hstack([pixels, np.ones((len(pixels), 1), "f4")]).ravel())
    picture.update()
    picture.pack()
    texture = nodes.new("ShaderNodeTexEnvironment")
    texture.image = picture
    links.new(texture.outputs["Color"], background.inputs["Color"])


def add_camera(scene, spec):
    camera = bpy.data.cameras.new("camera")
    width, height = spec["width_px"], spec["height_px"]
    scene.render.resolution_x, scene.render.resolution_y = width, height
    scene.render.resolution_percentage = 100
    scene.render.pixel_aspect_x = scene.render.pixel_aspect_y = 1
    camera.sensor_fit = "HORIZONTAL"
    camera.sensor_width = 36
    if spec["model"] == "pinhole":
        camera.lens = spec["fx_px"] / width * 36
        # Unequal focal lengths are unequal pixels.
        if spec["fy_px"] < spec["fx_px"]:
            scene.render.pixel_aspect_y = spec["fx_px"] / spec["fy_px"]
        elif spec["fx_px"] < spec["fy_px"]:
            scene.render.pixel_aspect_x = spec["fy_px"] / spec["fx_px"]
        camera.shift_x = -(spec["cx_px"] - (width - 1) / 2) / width
        camera.shift_y = (spec["cy_px"] - (height - 1) / 2) / width
    else:
        camera.type = "PANO"
        camera.cycles.panorama_type = "FISHEYE_LENS_POLYNOMIAL"
        camera.cycles.fisheye_fov = spec["fov_rad"]
        camera.sensor_width = width * spec["pixel_mm"]
        camera.sensor_height = height * spec["pixel_mm"]
        for i, k in enumerate(spec["polynomial"]):
            setattr(camera.cycles, "fisheye_polynomial_k%d" % i, k)
    camera.clip_start, camera.clip_end = spec["near_m"], spec["far_m"]
    thing = bpy.data.objects.new("camera", camera)
    # Blender's camera looks along -z with y up.
    flip = mathutils.Matrix.Diagonal((1, -1, -1, 1))
    thing.matrix_world = matrix(spec["world_from_camera"]) @ flip
    scene.collection.objects.link(thing)
    scene.camera = thing


def configure(scene, spec):
    scene.render.engine = "CYCLES"
    cycles = scene.cycles
    cycles.device = "CPU"
    scene.render.threads_mode = "FIXED"
    scene.render.threads = spec["threads"]
    scene.render.use_persistent_data = True
    cycles.use_denoising = False
    cycles.max_bounces = spec["max_bounces"]
    for name in ("diffuse", "glossy", "transmission"):
        setattr(cycles, name + "_bounces", spec["max_bounces"])
    cycles.transparent_max_bounces = spec["max_bounces"]
    cycles.sample_clamp_direct = cycles.sample_clamp_indirect = 0
    cycles.caustics_reflective = cycles.caustics_refractive = True
    cycles.blur_glossy = 0
    cycles.pixel_filter_type = "BOX"
    scene.render.film_transparent = False
    scene.view_settings.view_transform = "Raw"
    settings = scene.render.image_settings
    settings.file_format = "OPEN_EXR_MULTILAYER"
    settings.color_depth = "32"
    settings.exr_codec = "ZIP"
    layer = scene.view_layers[0]
    layer.name = "view"
    layer.use_pass_z = layer.use_pass_normal = layer.use_pass_object_index = True


def render(scene, run, path):
    cycles = scene.cycles
    cycles.samples = run["samples"]
    cycles.seed = run["seed"]
    cycles.use_adaptive_sampling = run["noise_threshold"] > 0
    cycles.adaptive_threshold = run["noise_threshold"]
    cycles.adaptive_min_samples = 0
    cycles.filter_width = run["filter_width_px"]
    scene.render.filepath = path
    begin = time.perf_counter()
    bpy.ops.render.render(write_still=False)
    seconds = time.perf_counter() - begin
    bpy.data.images["Render Result"].save_render(path, scene=scene)
    return seconds


def main():
    with open(os.path.join(FOLDER, "scene.json")) as file:
        spec = json.load(file)
    bpy.ops.wm.read_factory_settings(use_empty=True)
    scene = bpy.context.scene
    meshes = [make_mesh(model) for model in spec["models"]]
    materials = [make_material(material) for material in spec["materials"]]
    for instance in spec["instances"]:
        mesh = meshes[instance["model"]]
        thing = bpy.data.objects.new(instance["name"] or "instance", mesh)
        if not mesh.materials:
            mesh.materials.append(None)
        thing.material_slots[0].link = "OBJECT"
        thing.material_slots[0].material = materials[instance["material"]]
        thing.matrix_world = matrix(instance["world_from_object"])
        thing.pass_index = instance["index"]
        scene.collection.objects.link(thing)
    add_lights(scene, spec)
    add_camera(scene, spec["camera"])
    configure(scene, spec["settings"])
    if "blend" in spec:
        bpy.ops.wm.save_as_mainfile(filepath=os.path.join(FOLDER, spec["blend"]), check_existing=False)
    if "gltf" in spec:
        bpy.ops.export_scene.gltf(filepath=os.path.join(FOLDER, spec["gltf"]), export_cameras=True,
                                  export_lights=True)
    seconds = []
    for number, run in enumerate(spec["runs"]):
        seconds.append(render(scene, run, os.path.join(FOLDER, "run_%d.exr" % number)))
    with open(os.path.join(FOLDER, "times.json"), "w") as file:
        json.dump({"seconds": seconds, "blender": bpy.app.version_string}, file)


try:
    main()
except Exception:
    import traceback

    traceback.print_exc()
    sys.exit(1)
