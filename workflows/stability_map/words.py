"""The page's own words."""

BEFORE = [
    "# Numerical stability at the extremes",
    "",
    "What comes out when a simulation is pushed beyond reason. Each cell of the tables is a",
    "computation in a process of its own, compared with a reference that owes nothing to it:",
    "a closed form, modes by LAPACK on the full matrices, a Runge-Kutta run of order 8 by",
    "SciPy, or the method's own exact discrete motion. In the tables and figures stands",
    "",
    "- the relative error, where the result is **right**: 1 % or better (of the amplitude, of",
    "  the largest displacement, of the arm);",
    "- the error *in italics*, where it is **stable but inaccurate**: bounded, and not",
    "  growing;",
    "- **refused** or **diverged**: an error of one sentence says so, and what to try;",
    "- in bold capitals what must not be: a **HANG** (no answer within two minutes), a",
    "  **CRASH**, a **SILENT NaN**, or a **WRONG** answer called right: one that contradicts",
    "  the closed form of its law or method, or an energy that grows more than fourfold,",
    "  without a message.",
    "",
    "The bodies are tiny on purpose: what is looked at is rounding, conditioning and",
    "stability, not the mesh. Where the mesh is the question (bending, locking), the error is",
    "that of the mesh.",
]

ADVICE = [
    "## What to use when",
    "",
    "- **Free vibration and waves**: central differences at 0.9 of the limit if the limit is",
    "  affordable (it needs no solves); else implicit Newmark with 45 steps or more a period",
    "  of the highest mode that matters. Explicit methods refuse a step above the limit;",
    "  slivers and stiff, light or small cells lower it, and the message says to what.",
    "- **Large steps**: backward Euler, or Newmark with γ = 0.6, β = 0.3025, both converged",
    "  (`newton=None`). They kill what they do not resolve. Newmark's average acceleration is",
    "  stable for any step on a *linear* body only: on others it does not bound the energy.",
    "- **One iteration a step** is for steps that turn no part of the body by more than about",
    "  0.05 rad and resolve the motion that matters. Watch `StepReport.residuals` and the",
    "  energy balance: a residual near 1 means that the step was not solved, and nothing else",
    "  says so.",
    "- **Spins and large rotations**: less than 0.1 rad a step, `newton=None`, and never the",
    "  linear law, which takes a spin for a motion along straight lines and swells.",
    "- **Crushing and inversion**: `Invertible` of any law, or the exact corotational law.",
    "  Neo-Hooke and Mooney-Rivlin stop with a message before a cell is flat; St.",
    "  Venant-Kirchhoff lets cells pass through flatness and rest inside out, without stress,",
    "  as its energy says. Look at `Equilibrium.definite`: False is an equilibrium that is",
    "  not stable.",
    "- **Slender bodies**: order 2, and Cholesky or CG with GAMG; Jacobi's CG gives up from",
    "  about 1:200. For large rotations of beams beyond 1:100 take more cells along the axis",
    "  than twenty.",
    "- **Poisson's ratio above 0.45**: order 2. Order 1 locks: tetrahedra and hexahedra of",
    "  order 1 lose most of their deflection at 0.499.",
    "- **Units and scales**: any. Between 1 Pa and 1e13 Pa, 1 µm and 10 km, density contrasts",
    "  of a million, the digits stay.",
]

#: Chapter -> what to know for reading it.
AFTER = {
    "Time step": [
        "A clamped column of two cubes, its first bending mode with an amplitude of a tenth",
        "of its height, undamped. Columns are multiples of 2 / ω, the explicit limit of the",
        "body at rest. Forty steps are done, a hundred of the smallest. The linear body is",
        "compared with its exact motion and, to 1e-6, with each method's exact discrete motion;",
        "the others with the Runge-Kutta run of order 8, for 45 limits, which is more than a",
        "period. Where a step is longer than that, phases mean nothing, the error is given as",
        "1, and boundedness is what is tested.",
    ],
    "Young's modulus [Pa]": [
        "A block in uniaxial tension of E/20 against the closed form of each law (springs:",
        "SciPy's solution of the same network with E = 1 Pa); and a quarter period of its",
        "first mode in 25 steps against LAPACK's.",
    ],
    "Size of the body [m]": [
        "The same block, from a micrometre to ten kilometres.",
    ],
    "Poisson's ratio, uniaxial tension": [
        "The same block. The strain is homogeneous, so nothing locks: this is conditioning",
        "alone.",
    ],
    "Height of slivers": [
        "A cube of twelve tetrahedra about a node that lies this far from a face; tension as",
        "above. In the last two rows the step is a tenth of the cube's L √(ρ / E), whatever",
        "the slivers.",
    ],
    "Density contrast": [
        "A column of two cubes, one of them so many times as dense; a quarter period of the",
        "first mode against LAPACK's, in 25 steps, or at most 400 stable ones of the explicit",
        "methods.",
    ],
    "Slenderness": [
        "A cantilever of twenty quadratic hexahedra: small deflections against Timoshenko,",
        "large ones (load F L² / (E I) = 4) against the elastica, the frequency and the",
        "motion of the first mode against Euler and Bernoulli. Stocky beams differ from the",
        "elastica by their shear, slender ones by the cells' own stiffness in large",
        "rotations.",
    ],
    "Poisson's ratio, bending": [
        "A stocky cantilever, 6 x 2 x 2 cells (or six tetrahedra in each), against quadratic",
        "hexahedra of half the size: volumetric locking.",
    ],
    "Crushed to a stretch": [
        "Two cubes between walls, crushed to a prescribed height; the force on top against",
        "the closed form of each law. Italics: the even state is unstable, and another",
        "equilibrium was found; the error is the distance between the two.",
    ],
    "Dead pressure over λ + 2 μ": [
        "The same cubes under a dead pressure, against the branch of the law that comes from",
        "rest. St. Venant-Kirchhoff bears 0.19 at most; beyond, no answer is right.",
    ],
    "Recovery by backward Euler": [
        "A cube of eight cells let go from an impossible shape, 200 damped steps of backward",
        "Euler: the largest displacement that is left, over the edge. In italics: it rests in",
        "a wrong shape.",
    ],
    "Spin, radians a step": [
        "A free bar, centrifugal strains of 1e-4; places against those of a rigid body after",
        "up to 60 steps. Linear elasticity is compared with the straight lines that are",
        "exact for it.",
    ],
    "Steps without damping": [
        "One tetrahedron; the error is the drift of the energy between the first and the last",
        "tenth of the run. The linear body is compared, step by step, with the method's exact",
        "motion.",
    ],
}
