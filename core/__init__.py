"""The renderer. It runs, and is tested, without Blender: NumPy, numba, Embree.

What is here, in the order of the data: folders, and files of this folder. A module imports only
what stands above its own row, and from its own folder; nothing imports in a circle.

    _quicker, _kernel_files, _parts, _jit  how kernels are compiled and kept: @kernel
    data           what a Scene is made of, without numba: programs, lamps, motion, copies
    settings       every setting of a render, its default and its limits
    scene          what is rendered
    film           what a tile carries, and who takes it
    stats          what a render cost
    exr, exr_picture  OpenEXR files; what is shown of one with layers
    machine        threads, clocks, memory
    unit_square    Sobol's and Halton's points; the sphere as a square
    wavelets       sparse Haar series and their product; tables on disk
    textures       noise, cells and images at many places: kernels of nodes
    geometry       shading points on triangles
    embree         rays against triangles; accel.py is the door
    bsdf           surfaces and strands: parameters to lobes to numbers
    camera         pixel, lens and time to rays; the pixel filter
    light          the world's map, and its quadtree
    walks          light under surfaces
    nodes          shader nodes at shading points, and over the sphere
    fine_meshes    subdivision, dicing, displacement: before there is a Scene
    products       light x BSDF at a shading point; how points are warped by it
    sampling       mode UNBIASED's loop: rounds of samples, and when a pixel has enough
    see_through    what lets rays through; who sees which triangles
    paper_mode     mode PAPER: its tables and its sampler
    comparisons    estimators that no picture uses
    surfaces       materials at shading points: their closures, mixed
    lamplight      lamps and faces that shine: their shapes and samples
    passes         what pixels keep beside their light; sums to layers
    tiles          the work at a tile, from rays to layers; budgets
    denoising      Open Image Denoise
    render_cache   what is kept from one render to the next
    render         the entry point
    denoised_render, bake  the same without noise; pictures for surfaces
    windows        pictures for a window, coarse ones first
"""
