"""The paper's figures from our code: python -m iwis paper (docs/paper.md).

Not part of the extension. In the order of the data; needs no bpy but for the sample figure.

    files, materials          meshes and probes read; the material fits that come with IWIS
    inputs                    what is rendered: the user's data, or what comes with IWIS
    runs, metrics             pictures by every method; errors, rank correlation
    figure1 ... figure5       the data of each figure
    plots, pictures           drawn by matplotlib
    claims, report, command   what is said of them; paper.html; the command
"""
