"""The renderer. It runs, and is tested, without Blender: NumPy, numba, Embree.

In the order of the data; a module imports only from groups with a smaller number:

    _jit, settings, program                          0  how kernels are compiled; all defaults
    scene, sphere_map, haar, halton, film, stats,    1  plain data, maps, transforms, files
    microfacet, terminator, exr, embree_rays, lanes,
    pace
    camera, embree, albedo_tables, haar_forest,      2  rays, Embree, sparse Haar series
    environment, shading, watch, neighbours, merl,
    glossy_normal
    accel, lobes, pyramid, haar_product,             3  rays, materials at a point; light; products
    table_cache, sequence, stop_rule, tile_pool
    brdf, lobe_cells, product, tables, incremental,  4  the BSDF; light x BSDF; the paper's loop
    pixel_filter, cell_lookup, light_cache, light_leaves, trace_lanes, nodes,
    sample_plan, measured, lobe_setup
    product_build, warp, light_rays, paper_tables,   5  product sampling; the tables of a scene
    pass_sums, light_cells, surface, backdrop
    weigh, guide, paper_products, light_tree,        6  what samples bring, and teach; layers
    develop
    unbiased, paper, render_cache                    7  the two modes; what is kept
    block_loop, reference                            8  UNBIASED's loop; estimators to compare with
    two_stage, tile_job                              9  another one; a tile's work
    center_tile, filtered_tile, budget, warm_up     10  one shading point a pixel, several; BUDGET
    render                                          11  the entry point
    progressive, pixel_view                         12  pictures for a window; one pixel's samples
"""
