"""The renderer. It runs, and is tested, without Blender: NumPy, numba, Embree.

In the order of the data (a module imports only from lines above its own group):

    _jit, settings                           0  how kernels are compiled; the one home of defaults
    scene, frame, sphere_map, haar, halton,  1  plain data, geometry, transforms
    pyramid, exr, film, storage
    camera, accel, brdf, environment,        2  rays, Embree, materials, light
    haar_product
    tables, warp, product                    3  the paper's tables; points -> directions; the product at a point
    shading, estimator                       4  hits -> shading points; weights and e_d
    incremental, reference                   5  the paper's loop; plain estimators to compare with
    render                                   6  tiles, threads, cancel: render(scene, settings, sink)
"""
