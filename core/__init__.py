"""The renderer. It runs, and is tested, without Blender: NumPy, numba, Embree.

In the order of the data; a module imports only from groups with a smaller number:

    _kernel_files                                   -2  files of compiled kernels
    _parts, addresses                               -1  how kernels are put together; raw memory
    _jit, settings, program, lamps, object_motion,   0  how kernels are kept; all defaults
    compile_apart, rows, turns, asked_passes, bake_points, copies, channels
    scene, sphere_map, haar, halton, film, stats,    1  plain data, maps, transforms, files
    microfacet, terminator, exr, embree_rays, lanes, program_ops,
    pace, lamp_areas, lamp_meshes, lamp_falloff, lamp_cones, prefetch, sheen_numbers,
    triangle_pairs, near_meshes, perlin, texels, element_places, oidn, subsurface, walkers,
    luminance, lambert_kinds, subdivision, thin_film_tables
    panorama, panorama_places, embree_filter,        2  rays, sparse Haar series, points
    albedo_tables, haar_forest, environment, shading, watch, neighbours, merl,
    glossy_normal, lamp_shapes, lamp_pictures, emitter_tree, sheen, toon, islands,
    closed_meshes, clear_materials, embree_hits, denoise, hair_frame,
    bump, stretched, lobes, cell_numbers, shapes, gabor, copied_rows, bezier_patches,
    thin_film_seen
    lens, embree, lobes_at, pyramid, haar_product,   3  Embree; light; products
    table_cache, sequence, stop_rule, tile_pool, poses, rough_diffuse,
    voronoi_cells, cryptomatte, light_groups, posed_lamps, view_denoiser, bake_rays,
    walk_steps, round_points, hair, dicing_view, thin_film
    accel, brdf, lobe_cells, product, tables,        4  the BSDF; light x BSDF; materials
    camera, pixel_filter, cell_lookup, light_cache, light_leaves, trace_lanes,
    sample_plan, sample_order, measured, lobe_setup, embree_instances, hair_cells,
    hair_setup, hair_samples, bevel, dicing
    incremental, nodes, product_build, warp,         5  the paper's loop; product sampling
    light_rays, paper_tables, light_cells, lamp_rays, pass_rays, moving_accel,
    moved_accel, surface_numbers, near_rays, pixel_motion, random_walk, copied_accel,
    micropolygons, lamp_choice, thin_film_setup
    cutouts, pass_sums, weigh, guide,                6  what samples bring, and teach; layers
    paper_products, light_tree, backdrop, emission_parts, like_products, closure_columns,
    displacement, lamp_light, moving_copies, patch_values
    surface, opacity, unbiased, paper, develop,      7  shaders at points; the two modes
    emitters, lamp_glow, light_edges
    block_loop, reference, catchers, ray_masks,      8  UNBIASED's loop; estimators to compare with
    unbiased_rays, shader_values, roughness, seen_points
    two_stage, tile_job, scene_rays, loop_types,     9  another one; a tile's work; their rays
    surface_passes
    merged_layers, tile_lamps, budget, warm_up,     10  closures together; BUDGET; what is kept
    silhouettes, time_slices, ambient_occlusion, early_kernels, tiles, walked_layers,
    render_cache
    pass_samples, pass_plan                         11  passes of a tile, how many are wanted
    center_tile, filtered_tile                      12  one shading point a pixel, several
    render                                          13  the entry point
    shown_picture, pixel_view, denoised_render, bake  14  pictures for a window; one pixel's samples
    coarse_pictures                                 15  the first of them
    progressive                                     16  all of them
"""
