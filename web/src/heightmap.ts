// The stock as a height map: heights and values in textures, x and y from the number of the vertex, tiles that share
// their index buffer, coarser ones where a cell is smaller than 1.5 px.
import * as THREE from "three";
import { Choice } from "./file";
import { Run } from "./run";
import { bodyMaterial, mapMaterial, tableTexture } from "./shaders";

const TILE = 200;
const MISSING = 65535;
export const UNCUT = 0xbfc4c9;
export const CUT = 0x8c97a3;

interface Level {
  group: THREE.Group;
  cell: number;
}

export class HeightMap {
  readonly object = new THREE.Group();
  readonly box = new THREE.Box3();
  readonly rows: number;
  readonly columns: number;
  private readonly levels: Level[] = [];
  private readonly before = { value: false };
  private readonly height: Uint16Array;
  private readonly owner: Uint32Array | null;
  private readonly zero: number;
  private readonly scale: number;

  constructor(private readonly run: Run) {
    const file = run.file;
    const map = run.header.scene.map!;
    const entry = file.entry("m/height");
    [this.rows, this.columns] = entry.shape;
    this.zero = entry.zero;
    this.scale = entry.scale;
    this.height = file.raw("m/height") as Uint16Array;
    this.owner = file.has("m/owner") ? (file.raw("m/owner") as Uint32Array) : null;
    const choice = run.header.colour.choices[map.coloured] as Choice | undefined;
    const values = choice && file.has("m/value") ? (file.raw("m/value") as Uint16Array) : null;
    const table = choice ? tableTexture(run.table(choice)) : null;
    let step = { height: this.height, values, rows: this.rows, columns: this.columns, size: 1 };
    const zeroOfValue = values ? file.entry("m/value").zero : 0;
    const scaleOfValue = values ? file.entry("m/value").scale : 0;
    for (let number = 0; number < 4; number++) {
      this.levels.push(this.level(step, choice, table, zeroOfValue, scaleOfValue));
      if (step.rows * step.columns < 40_000) break;
      step = coarser(step, zeroOfValue, scaleOfValue);
    }
    this.levels.forEach((level, k) => {
      level.group.visible = k === 0;
      this.object.add(level.group);
    });
    this.object.add(this.sides());
    this.box.set(
      new THREE.Vector3(map.x, map.y, map.bottom),
      new THREE.Vector3(map.x + this.columns * map.dx, map.y + this.rows * map.dy, map.top),
    );
  }

  showBefore(on: boolean): void {
    this.before.value = on;
  }

  get showsBefore(): boolean {
    return this.before.value;
  }

  /** Chooses the level whose cells are at least 1.5 px wide. */
  refine(pixelsPerMm: number): void {
    let chosen = 0;
    while (chosen < this.levels.length - 1 && this.levels[chosen].cell * pixelsPerMm < 1.5) chosen++;
    this.levels.forEach((level, k) => (level.group.visible = k === chosen));
  }

  heightAt(x: number, y: number): number | null {
    const k = this.cellAt(x, y);
    if (k === null) return null;
    return this.height[k] === MISSING ? null : this.zero + this.scale * this.height[k];
  }

  cellAt(x: number, y: number): number | null {
    const map = this.run.header.scene.map!;
    const i = Math.floor((x - map.x) / map.dx);
    const j = Math.floor((y - map.y) / map.dy);
    return i < 0 || j < 0 || i >= this.columns || j >= this.rows ? null : j * this.columns + i;
  }

  /** Where a ray first meets the surface, and the sample that cut the cell there last (null: none). */
  hit(ray: THREE.Ray): { point: THREE.Vector3; sample: number | null } | null {
    const enter = new THREE.Vector3();
    if (!ray.intersectBox(this.box.clone().expandByScalar(1e-6), enter)) return null;
    const map = this.run.header.scene.map!;
    const step = 0.5 * Math.min(map.dx, map.dy);
    const p = this.box.containsPoint(ray.origin) ? ray.origin.clone() : enter;
    const move = ray.direction.clone().multiplyScalar(step);
    const most = Math.ceil(this.box.getSize(new THREE.Vector3()).length() / step) + 2;
    for (let n = 0; n < most; n++, p.add(move)) {
      const cell = this.cellAt(p.x, p.y);
      if (cell === null) continue;
      const q = this.height[cell];
      if (q === MISSING && !this.before.value) continue;
      const z = this.before.value ? map.top : this.zero + this.scale * q;
      if (p.z <= z) {
        const owner = this.owner ? this.owner[cell] : 0xffffffff;
        return { point: p.clone(), sample: owner === 0xffffffff ? null : owner };
      }
    }
    return null;
  }

  private level(step: Step, choice: Choice | undefined, table: THREE.DataTexture | null, zero: number, scale: number): Level {
    const map = this.run.header.scene.map!;
    const group = new THREE.Group();
    const heights = integers(step.height, step.columns, step.rows);
    const values = step.values ? integers(step.values, step.columns, step.rows) : null;
    const shape = tile(Math.min(TILE, Math.max(step.rows, step.columns)));
    const cell = new THREE.Vector2((map.dx * this.columns) / step.columns, (map.dy * this.rows) / step.rows);
    if (step.size > 1) cell.set(map.dx * step.size, map.dy * step.size);
    for (let row = 0; row < step.rows - 1; row += TILE) {
      for (let column = 0; column < step.columns - 1; column += TILE) {
        const material = mapMaterial(
          { heights, values, table, low: choice?.low ?? 0, high: choice?.high ?? 1 },
          {
            corner: { value: new THREE.Vector2(map.x, map.y) },
            cell: { value: cell },
            first: { value: new THREE.Vector2(column, row) },
            size: { value: new THREE.Vector2(step.columns, step.rows) },
            side: { value: shape.side },
            zero: { value: this.zero },
            scale: { value: this.scale },
            top: { value: map.top },
            before: this.before,
            uncut: { value: plain(UNCUT) },
            cut: { value: plain(CUT) },
            valueZero: { value: zero },
            valueScale: { value: scale },
          },
        );
        const mesh = new THREE.Mesh(shape.geometry, material);
        mesh.frustumCulled = false;
        group.add(mesh);
      }
    }
    return { group, cell: Math.min(cell.x, cell.y) };
  }

  /** Sides and underside, so that the stock is a body. */
  private sides(): THREE.Object3D {
    const map = this.run.header.scene.map!;
    const [rows, columns] = [this.rows, this.columns];
    const ring: [number, number][] = [];
    for (let i = 0; i < columns; i++) ring.push([i, 0]);
    for (let j = 1; j < rows; j++) ring.push([columns - 1, j]);
    for (let i = columns - 2; i >= 0; i--) ring.push([i, rows - 1]);
    for (let j = rows - 2; j >= 0; j--) ring.push([0, j]);
    const points: number[] = [];
    const corners: number[] = [];
    for (const [i, j] of ring) {
      const q = this.height[j * columns + i];
      const z = q === MISSING ? map.bottom : this.zero + this.scale * q;
      const x = map.x + (i + 0.5) * map.dx;
      const y = map.y + (j + 0.5) * map.dy;
      points.push(x, y, z, x, y, map.bottom);
    }
    for (let k = 0; k < ring.length; k++) {
      const a = 2 * k;
      const b = 2 * ((k + 1) % ring.length);
      corners.push(a, a + 1, b, b, a + 1, b + 1);
    }
    const geometry = new THREE.BufferGeometry();
    geometry.setAttribute("position", new THREE.Float32BufferAttribute(points, 3));
    geometry.setIndex(corners);
    const body = new THREE.Group();
    body.add(new THREE.Mesh(geometry, bodyMaterial({ tint: UNCUT })));
    const floor = new THREE.PlaneGeometry(map.dx * (columns - 1), map.dy * (rows - 1));
    floor.translate(map.x + 0.5 * map.dx * columns, map.y + 0.5 * map.dy * rows, map.bottom);
    body.add(new THREE.Mesh(floor, bodyMaterial({ tint: UNCUT })));
    const box = new THREE.BoxGeometry(map.dx * (columns - 1), map.dy * (rows - 1), map.top - map.bottom);
    box.translate(map.x + 0.5 * map.dx * columns, map.y + 0.5 * map.dy * rows, 0.5 * (map.top + map.bottom));
    const lines = new THREE.LineSegments(new THREE.EdgesGeometry(box), new THREE.LineBasicMaterial({ color: 0x39424d, transparent: true, opacity: 0.35 }));
    body.add(lines);
    return body;
  }
}

interface Step {
  height: Uint16Array;
  values: Uint16Array | null;
  rows: number;
  columns: number;
  size: number;
}

/** Every second cell, with the value of greatest magnitude of its four, and the height where that is. */
function coarser(step: Step, zero: number, scale: number): Step {
  const rows = Math.ceil(step.rows / 2);
  const columns = Math.ceil(step.columns / 2);
  const height = new Uint16Array(rows * columns);
  const values = step.values ? new Uint16Array(rows * columns) : null;
  for (let j = 0; j < rows; j++) {
    for (let i = 0; i < columns; i++) {
      let best = 2 * j * step.columns + 2 * i;
      let most = -1;
      for (const [b, a] of [[0, 0], [0, 1], [1, 0], [1, 1]]) {
        if (2 * j + b >= step.rows || 2 * i + a >= step.columns) continue;
        const k = (2 * j + b) * step.columns + 2 * i + a;
        const q = step.values ? step.values[k] : MISSING;
        const size = q === MISSING ? -0.5 : Math.abs(zero + scale * q);
        if (size > most) {
          most = size;
          best = k;
        }
      }
      height[j * columns + i] = step.height[best];
      if (values && step.values) values[j * columns + i] = step.values[best];
    }
  }
  return { height, values, rows, columns, size: 2 * step.size };
}

function integers(data: Uint16Array, width: number, height: number): THREE.DataTexture {
  const texture = new THREE.DataTexture(data, width, height, THREE.RedIntegerFormat, THREE.UnsignedShortType);
  texture.internalFormat = "R16UI";
  texture.unpackAlignment = 2;
  texture.needsUpdate = true;
  return texture;
}

const tiles = new Map<number, { geometry: THREE.BufferGeometry; side: number }>();

/** A square of cells; the places come from the numbers of its vertices. */
function tile(cells: number): { geometry: THREE.BufferGeometry; side: number } {
  const known = tiles.get(cells);
  if (known) return known;
  const side = cells + 1;
  const corners = new Uint32Array(6 * cells * cells);
  let n = 0;
  for (let j = 0; j < cells; j++) {
    for (let i = 0; i < cells; i++) {
      const a = j * side + i;
      corners.set([a, a + 1, a + side, a + 1, a + side + 1, a + side], n);
      n += 6;
    }
  }
  const geometry = new THREE.BufferGeometry();
  geometry.setAttribute("position", new THREE.BufferAttribute(new Float32Array(3 * side * side), 3));
  geometry.setIndex(new THREE.BufferAttribute(corners, 1));
  const made = { geometry, side };
  tiles.set(cells, made);
  return made;
}

function plain(hex: number): THREE.Vector3 {
  return new THREE.Vector3((hex >> 16) / 255, ((hex >> 8) & 255) / 255, (hex & 255) / 255);
}
