// The path as a ribbon of constant width on the screen, flat in colour from sample to sample.
import * as THREE from "three";
import { History, Run } from "./run";
import { ribbonMaterial } from "./shaders";

const RAPID = 0;
const NOT_DRAWN = 3; // the tool stands still, or goes from one path to the next
const NONE = -1; // in place of a colour: a thin grey line

export class Ribbon {
  readonly object: THREE.Mesh;
  private readonly samples: number[] = [];
  private readonly colours: THREE.InstancedBufferAttribute;

  constructor(private readonly run: Run) {
    const from: number[] = [];
    const to: number[] = [];
    const sample: number[] = [];
    const kind: number[] = [];
    for (let i = 0; i < run.count - 1; i++) {
      if (run.kind && run.kind[i] === NOT_DRAWN) continue;
      const a = run.traceAt(i);
      const b = run.traceAt(i + 1);
      if (a[0] === b[0] && a[1] === b[1] && a[2] === b[2]) continue;
      from.push(...a);
      to.push(...b);
      sample.push(i);
      kind.push(run.kind ? run.kind[i] : 2);
      this.samples.push(i);
    }
    const geometry = new THREE.InstancedBufferGeometry();
    geometry.setAttribute("position", new THREE.Float32BufferAttribute([0, -1, 0, 1, -1, 0, 1, 1, 0, 0, 1, 0], 3));
    geometry.setIndex([0, 1, 2, 0, 2, 3]);
    geometry.setAttribute("from", new THREE.InstancedBufferAttribute(new Float32Array(from), 3));
    geometry.setAttribute("to", new THREE.InstancedBufferAttribute(new Float32Array(to), 3));
    geometry.setAttribute("stamp", new THREE.InstancedBufferAttribute(new Float32Array(sample), 1));
    geometry.setAttribute("kind", new THREE.InstancedBufferAttribute(new Float32Array(kind), 1));
    this.colours = new THREE.InstancedBufferAttribute(new Float32Array(from.length), 3);
    geometry.setAttribute("colour", this.colours);
    geometry.instanceCount = this.samples.length;
    this.object = new THREE.Mesh(geometry, ribbonMaterial());
    this.object.frustumCulled = false;
    this.object.renderOrder = 2;
  }

  colour(by: History | undefined): void {
    const array = this.colours.array as Float32Array;
    this.samples.forEach((i, k) => {
      const rapid = this.run.kind && this.run.kind[i] === RAPID;
      const rgb = by && !rapid && !Number.isNaN(by.values[i]) ? this.run.colour(by.choice, by.values[i]) : null;
      for (let c = 0; c < 3; c++) array[3 * k + c] = rgb ? rgb[c] / 255 : NONE;
    });
    this.colours.needsUpdate = true;
  }
}
