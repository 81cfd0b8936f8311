// The sample nearest to a point of the screen or of space, among a million: balls round 256 samples each are looked at first.
import * as THREE from "three";
import { Run } from "./run";

const BLOCK = 256;

export class Nearest {
  private readonly balls: Float32Array; // middle and radius

  constructor(private readonly run: Run) {
    const { count, trace } = run;
    const blocks = Math.ceil(count / BLOCK);
    this.balls = new Float32Array(4 * blocks);
    const box = new THREE.Box3();
    const p = new THREE.Vector3();
    const ball = new THREE.Sphere();
    for (let b = 0; b < blocks; b++) {
      box.makeEmpty();
      for (let i = b * BLOCK; i < Math.min(count, (b + 1) * BLOCK); i++) box.expandByPoint(p.set(trace[i], trace[count + i], trace[2 * count + i]));
      box.getBoundingSphere(ball);
      this.balls.set([ball.center.x, ball.center.y, ball.center.z, ball.radius], 4 * b);
    }
  }

  /** Nearest on the screen within some pixels; `m`: to clip space, `half`: of the picture in pixels. */
  onScreen(m: number[], x: number, y: number, half: { x: number; y: number }, within: number): number | null {
    const { count, trace } = this.run;
    let best: number | null = null;
    let least = within;
    const row = (r: number) => Math.hypot(m[r], m[4 + r], m[8 + r]);
    const [rx, ry, rw] = [row(0), row(1), row(3)];
    for (let b = 0; 4 * b < this.balls.length; b++) {
      const [cx, cy, cz, radius] = this.balls.subarray(4 * b, 4 * b + 4);
      const w = m[3] * cx + m[7] * cy + m[11] * cz + m[15];
      const nearest = w - rw * radius; // least w in the ball
      if (w + rw * radius <= 0) continue;
      if (nearest > 0) {
        const px = ((m[0] * cx + m[4] * cy + m[8] * cz + m[12]) / w) * half.x - x;
        const py = ((m[1] * cx + m[5] * cy + m[9] * cz + m[13]) / w) * half.y - y;
        // how far a place of the ball can lie from its middle on the screen
        const off = (clip: number, r: number) => (r * radius + Math.abs(clip) * rw * radius) / nearest;
        const dx = Math.max(0, Math.abs(px) - off((px + x) / half.x, rx) * half.x);
        const dy = Math.max(0, Math.abs(py) - off((py + y) / half.y, ry) * half.y);
        if (Math.hypot(dx, dy) > least) continue;
      }
      for (let i = b * BLOCK; i < Math.min(count, (b + 1) * BLOCK); i++) {
        const [u, v, z] = [trace[i], trace[count + i], trace[2 * count + i]];
        const depth = m[3] * u + m[7] * v + m[11] * z + m[15];
        if (depth <= 0) continue;
        const d = Math.hypot(((m[0] * u + m[4] * v + m[8] * z + m[12]) / depth) * half.x - x, ((m[1] * u + m[5] * v + m[9] * z + m[13]) / depth) * half.y - y);
        if (d < least) [least, best] = [d, i];
      }
    }
    return best;
  }

  /** Nearest in space. */
  inSpace(p: THREE.Vector3): number | null {
    const { count, trace } = this.run;
    let best: number | null = null;
    let least = Infinity;
    for (let b = 0; 4 * b < this.balls.length; b++) {
      const [cx, cy, cz, radius] = this.balls.subarray(4 * b, 4 * b + 4);
      if (Math.hypot(cx - p.x, cy - p.y, cz - p.z) - 1.000001 * radius - 1e-6 > least) continue;
      for (let i = b * BLOCK; i < Math.min(count, (b + 1) * BLOCK); i++) {
        const d = Math.hypot(trace[i] - p.x, trace[count + i] - p.y, trace[2 * count + i] - p.z);
        if (d < least) [least, best] = [d, i];
      }
    }
    return best;
  }
}
