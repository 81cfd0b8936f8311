// The path as a ribbon of constant width on the screen, flat in colour from sample to sample. The places stand in one buffer,
// read at an instance and at the next one; the number of a sample is that of its instance.
import * as THREE from "three";
import { History, Run } from "./run";
import { ribbonMaterial } from "./shaders";

const RAPID = 0;
const NOT_DRAWN = 3; // the tool stands still, or goes from one path to the next

export class Ribbon {
  readonly object: THREE.Mesh;
  private readonly colours: THREE.InstancedBufferAttribute; // red, green, blue; the last byte is 0 where there is no colour: a thin grey line

  constructor(private readonly run: Run) {
    const { count, trace } = run;
    const drawn = Math.max(0, count - 1);
    const places = new Float32Array(3 * Math.max(2, count));
    for (let i = 0; i < count; i++) for (let c = 0; c < 3; c++) places[3 * i + c] = trace[c * count + i];
    const kinds = new Uint8Array(drawn);
    for (let i = 0; i < drawn; i++) {
      const stands = trace[i] === trace[i + 1] && trace[count + i] === trace[count + i + 1] && trace[2 * count + i] === trace[2 * count + i + 1];
      kinds[i] = stands ? NOT_DRAWN : run.kind ? run.kind[i] : 2;
    }
    const geometry = new THREE.InstancedBufferGeometry();
    geometry.setAttribute("position", new THREE.Float32BufferAttribute([0, -1, 0, 1, -1, 0, 1, 1, 0, 0, 1, 0], 3));
    geometry.setIndex([0, 1, 2, 0, 2, 3]);
    const shared = new THREE.InstancedInterleavedBuffer(places, 3);
    geometry.setAttribute("from", new THREE.InterleavedBufferAttribute(shared, 3, 0));
    geometry.setAttribute("to", new THREE.InterleavedBufferAttribute(shared, 3, 3));
    geometry.setAttribute("kind", new THREE.InstancedBufferAttribute(kinds, 1));
    this.colours = new THREE.InstancedBufferAttribute(new Uint8Array(4 * drawn), 4, true);
    geometry.setAttribute("colour", this.colours);
    geometry.instanceCount = drawn;
    this.object = new THREE.Mesh(geometry, ribbonMaterial());
    this.object.frustumCulled = false;
    this.object.renderOrder = 2;
  }

  colour(by: History | undefined): void {
    const array = this.colours.array as Uint8Array;
    const { kind } = this.run;
    array.fill(0);
    if (by) {
      const table = this.run.table(by.choice);
      for (let i = 0; 4 * i < array.length; i++) {
        const value = by.values[i];
        if ((kind && kind[i] === RAPID) || Number.isNaN(value)) continue;
        const k = 3 * this.run.index(by.choice, value);
        array[4 * i] = table[k];
        array[4 * i + 1] = table[k + 1];
        array[4 * i + 2] = table[k + 2];
        array[4 * i + 3] = 255;
      }
    }
    this.colours.needsUpdate = true;
  }
}
