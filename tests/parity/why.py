"""Why cases differ that do: what was found out, by the case's name."""

_EDGES = "edges of a pattern fall between two pixels, and steep highlights; tones agree"
_RAYS = "Cycles follows BSDF rays through it as well, whose Light Path is another"
_MOVES = "noise where things move, in slices of the time (record 24); tones agree"
_HORIZON = "one row of pixels, in which the sky triples within two texels of .18 degrees"
_FINE = "highlights and strands finer than a pixel; tones agree"
_RIBBONS = "Cycles' flat ribbons face the ray and end in a line: less of them is seen from above"
_ELLIPSOIDS = (
    "Cycles' ellipsoids do not shadow themselves, though their normals lead away from the centre: "
    "likely light from below the true surface"
)
_OVERLAPS = "where they lie one behind the other; tones agree within .3 %"
_DARKER = "where strands that let light through overlap, Cycles is 1 to 2 % darker: not known why"
_CUT = "in 2 of 1000 pixels, not known why"
_OBLIQUE = "Cycles' points lie in the slanting plane, light counts as in that across the axis"
_CONES = "Cycles' linear curves have round joints and ends"

_STRAIGHT = "with direct light alone Cycles is black where a refracted ray ends in the body"

_ALONG = "where the tangent is along the normal (the floor) Cycles is black, IWIS round"

_NEAR = "Cycles' light samples know of no occlusion there, as here; its BSDF samples do: a mixture"

_BELLS = "Cycles evaluates it over other directions than it samples (record 41)"

_STRETCHED = (
    "on faces that are stretched far, at the edges of the cube; others agree: not known why"
)

_HARD = "at the edges, a pixel wide, where hard sides meet or come apart; faces agree"

_ASIDE = (
    "seen at grazing angles: Cycles mirrors its own samples to elsewhere where a facet is turned "
    "away from the viewer, and is brighter than its formula; its light samples agree"
)

_OF_THE_DISC = "a direction has the mean over the disc, of which shadows and cones show parts"

WHY = {
    "Lamp's nodes: soft ball, place on it, scaled": _OF_THE_DISC,
    "Lamp's nodes: soft spot, place on it": _OF_THE_DISC,
    "Displacement of vertices, hard edges, normals": _HARD,
    "Displacement of vertices and bump, hard edges, normals": _HARD,
    "Displacement of vertices and bump, vector in tangent space, normals": _STRETCHED,
    "Displacement of vertices and bump, vector in tangent space": _STRETCHED,
    "Ashikhmin-Shirley, roughness 0.6": _ASIDE,
    "Ashikhmin-Shirley, roughness 1.0": _ASIDE,
    "Ashikhmin-Shirley, anisotropy 0.7": _ASIDE,
    "Ashikhmin-Shirley, anisotropy .9, rough": _ASIDE,
    "Ambient Occlusion above a threshold": "the few rays of a point lie otherwise: worst there",
    "Ambient Occlusion as alpha": _NEAR,
    "Ambient Occlusion as light of a cube": _NEAR,
    "Tangent, radial X": _ALONG,
    "Tangent, radial Y": _ALONG,
    "Glass": _STRAIGHT,
    "Glass, rough": _STRAIGHT,
    "Principled, transmission": _STRAIGHT,
    "Thin film: Glass, roughness 0.1": _STRAIGHT,
    "Thin film: Glass, roughness 0.5": _STRAIGHT,
    "Thin film: transmission": _STRAIGHT,
    "Points, that let half of the light through": _OVERLAPS,
    "Curves, that let half of the light through": _DARKER,
    "Hair, light from under points": "walks in Cycles' points miss the sphere that they are in",
    "Points, scaled and turned": _ELLIPSOIDS,
    "Points, scaled unevenly, two instances": _ELLIPSOIDS,
    "Curves, diffuse, radius varies, ribbons": _RIBBONS,
    "Curves, diffuse, linear 3D": _CONES,
    "Area under an uneven scale, RECTANGLE, from behind": _CUT,
    "Area under an uneven scale, ELLIPSE": _OBLIQUE,
    "Curves, Poly": _CONES,
    "Particle hair, plastic, children": _FINE,
    "Particle hair, Intercept": _FINE,
    "Holdout, mixed": "holes are drawn by the place: noise of .03, which both seeds share in part",
    "Subsurface: Christensen-Burley": "it is rendered as Random Walk, and warned of",
    "Transparent to shadow rays": _RAYS,
    "Sky, multiple scattering, horizon seen": _HORIZON,
    "Transparent by a checker": _EDGES,
    "Translucent leaf, glossy and cut out": _EDGES,
    "Principled, alpha by noise": _EDGES,
    "Camera objects in motion, glowing checks": _MOVES,
    "Motion of an object that shines": _MOVES,
    "Motion of a shape that shines": _MOVES,
    "Adaptive subdivision, Pointiness": (
        "Cycles of Blender 5.2 has another one from render to render; 4.5 agrees to four digits"
    ),
    "Hair, Principled, blond ribbons": "Cycles' ribbons end in a line (record 27); tones agree",
    "Hair, Hair BSDF, reflection": _BELLS,
    "Hair, Hair BSDF, transmission": _BELLS,
    "Hair, Hair BSDF, transmission, offset": _BELLS,
}
