"""Regenerative milling loop (2 modes, 4 flutes, 20 discs): steps per CPU second, against a C++ twin of the same loop.

Both run the same cut, in this process and in one run; without g++ only our own figure is printed.
Run: python benchmarks/regenerative.py
"""

import math
import shutil
import subprocess
import tempfile
import time
from pathlib import Path

import numpy as np

from cutwise.physics.cutting.flute import EdgeCoefficients
from cutwise.physics.cutting.regenerative import fed_surface, tooth_grid
from cutwise.physics.structure.modes import modes, transition
from cutwise.process import loops_regenerative
from cutwise.process.loops_regenerative import SteadyCut

TWIN = r"""
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <vector>
int main(int argc, char** argv) {
  FILE* f = fopen(argv[1], "rb"); long n = atol(argv[2]);
  int head[4]; if (fread(head, 4, 4, f) != 4) return 1;
  const int M = head[0], D = head[1], tooth = head[2], modes = head[3], teeth = M / tooth;
  auto read = [&](size_t k) { std::vector<double> v(k); if (fread(v.data(), 8, k, f) != k) exit(1); return v; };
  auto nx = read((size_t)M * D), ny = read((size_t)M * D), s = read((size_t)M * D);
  auto any = read(M), st = read(6 * modes), al = read(2 * modes), c = read(6);
  std::vector<double> z(2 * modes, 0.0), tip(2 * n), force(2 * n);
  double ofx = 0, ofy = 0; clock_t t0 = clock();
  for (long k = 0; k < n; ++k) {
    double ux = 0, uy = 0;
    for (int m = 0; m < modes; ++m) { ux += z[2*m] * al[2*m]; uy += z[2*m] * al[2*m+1]; }
    double x = ux + c[5] * k, hx = 0, hy = 0, ex = 0, ey = 0; int q = k % M;
    for (int i = 0; i < teeth; ++i) {
      if (any[q] > 0) {
        const double *a = &nx[(size_t)q*D], *b = &ny[(size_t)q*D]; double* o = &s[(size_t)q*D];
        double p0 = 0, p1 = 0, p2 = 0, p3 = 0;
        for (int d = 0; d < D; ++d) {
          double h = x * a[d] + uy * b[d] - o[d], w = h > c[4] ? 1.0 : 0.0; h = h > c[4] ? h : 0.0; o[d] += h;
          p0 += h * a[d]; p1 += h * b[d]; p2 += w * a[d]; p3 += w * b[d];
        }
        hx += p0; hy += p1; ex += p2; ey += p3;
      }
      q -= tooth; if (q < 0) q += M;
    }
    double fx = -(c[0]*hy + c[2]*ey) - (c[1]*hx + c[3]*ex), fy = (c[0]*hx + c[2]*ex) - (c[1]*hy + c[3]*ey);
    double ax = 1.5*fx - 0.5*ofx, ay = 1.5*fy - 0.5*ofy; ofx = fx; ofy = fy;
    for (int m = 0; m < modes; ++m) {
      double g = ax * al[2*m] + ay * al[2*m+1], p = z[2*m], v = z[2*m+1]; const double* e = &st[6*m];
      z[2*m] = e[0]*p + e[1]*v + e[2]*g; z[2*m+1] = e[3]*p + e[4]*v + e[5]*g;
    }
    tip[2*k] = ux; tip[2*k+1] = uy; force[2*k] = fx; force[2*k+1] = fy;
  }
  printf("%.9f %.17g %.17g\n", double(clock() - t0) / CLOCKS_PER_SEC, tip[2*n-2], tip[2*n-1]);
}
"""


def main() -> None:
    """Time both on the same inputs, three times in turn, and print the best of each."""
    steps, periods = 200, 10_000
    tip = modes([922 * 2 * math.pi] * 2, [0.011] * 2, [1.34005e6] * 2, [[1, 0], [0, 1]])
    helix = math.tan(math.radians(30.0)) / 0.01
    print("2 modes, 4 flutes, 20 discs, 200 steps per tooth period; million steps per CPU second")
    for immersion in (1.0, 0.5, 0.1):
        cut = SteadyCut(4, 8000 * math.pi / 30, math.acos(2 * immersion - 1), math.pi, 1e-4, 0.05e-3, helix, 20,
                        EdgeCoefficients(600e6, 200e6, 0.0, 10e3, 10e3, 0.0))  # fmt: skip
        ours, twin = [], []
        loops_regenerative._simulate(cut, tip, 10, steps)
        with tempfile.TemporaryDirectory() as folder:
            binary = _build(Path(folder), cut, tip, steps)
            for _ in range(3):
                start = time.process_time()
                path, _force = loops_regenerative._simulate(cut, tip, periods, steps)
                ours.append(time.process_time() - start)
                if binary:
                    text = subprocess.run(
                        [binary, binary.with_suffix(".in"), str(periods * steps)],
                        check=True,
                        capture_output=True,
                        text=True,
                    ).stdout.split()
                    twin.append(float(text[0]))
                    assert np.allclose(path[-1], [float(text[1]), float(text[2])], rtol=1e-6, atol=1e-15)
        rate = periods * steps / min(ours) / 1e6
        line = f"  a_e/D {immersion:3.1f}: cutwise {rate:6.1f}"
        if twin:
            line += f", C++ -O3 -march=native -ffast-math {periods * steps / min(twin) / 1e6:6.1f}, "
            line += f"ratio {min(twin) / min(ours):.2f}"
        print(line)


def _build(folder: Path, cut: SteadyCut, tip, steps: int) -> Path | None:  # type: ignore[no-untyped-def]
    if shutil.which("g++") is None:
        return None
    source, binary = folder / "twin.cpp", folder / "twin"
    source.write_text(TWIN)
    subprocess.run(["g++", "-O3", "-march=native", "-ffast-math", "-o", binary, source], check=True)
    thickness = cut.depth / cut.discs
    lag = (np.arange(cut.discs) + 0.5) * thickness * cut.lag_per_depth
    grid = tooth_grid(cut.teeth, steps, lag, cut.entry, cut.exit)
    k, dt = cut.coefficients, 2 * math.pi / (cut.spindle * cut.teeth * steps)
    exact = np.array([transition(float(w), float(z), float(m), dt) for w, z, m, _ in zip(*tip, strict=True)])
    forces = thickness * np.array([k.K_tc, k.K_rc, k.K_te, k.K_re])
    with binary.with_suffix(".in").open("wb") as file:
        np.array([*grid.normal_x.shape, steps, tip.frequency.size], dtype=np.int32).tofile(file)
        for values in (grid.normal_x, grid.normal_y, fed_surface(grid, cut.feed_per_tooth),
                       grid.any_inside.astype(float), exact, tip.direction,
                       np.append(forces, [0.0, cut.feed_per_tooth / steps])):  # fmt: skip
            np.ascontiguousarray(values, dtype=np.float64).tofile(file)
    return binary


if __name__ == "__main__":
    main()
