// The scene in 3D: what there is of part, stock, path, tool and what carries it; drawn when something has changed.
import * as THREE from "three";
import { OrbitControls } from "three/examples/jsm/controls/OrbitControls.js";
import { HeightMap } from "./heightmap";
import { Nearest } from "./nearest";
import { Ribbon } from "./ribbon";
import { Run } from "./run";
import { bodyMaterial, shared, tableTexture } from "./shaders";
import { arm, bodied, bodies, EDGE, housed, turned, welded } from "./solids";

const FIELD = 35; // degrees
const NEAR_PIXELS = 12;
const INNER = -1; // in place of a face: both sides of an edge are of one
const FILLED = 0.86; // of the picture, by part and stock
const TINTS: Record<string, { tint: number; opacity: number }> = {
  work: { tint: 0xb9c0c8, opacity: 1 },
  part: { tint: 0xb9c0c8, opacity: 1 },
  glass: { tint: 0xb9c0c8, opacity: 0.38 },
  burr: { tint: 0xcc8a1e, opacity: 0.35 },
  ghost: { tint: 0x808890, opacity: 0.3 },
  machine: { tint: 0x8fa3b8, opacity: 0.55 },
  robot: { tint: 0xd9741f, opacity: 0.45 },
};

export type Preset = "fit" | "all" | "iso" | "top" | "front" | "right" | "tool" | "worst";
export const PRESETS: Preset[] = ["iso", "top", "front", "right", "tool", "worst"];

export interface Picked {
  sample: number | null;
  place: [number, number, number];
  name: string; // of the surface or face, as the scenario would say it
}

export class View3D {
  readonly map: HeightMap | null;
  readonly controls: OrbitControls;
  private readonly renderer: THREE.WebGLRenderer;
  private readonly scene = new THREE.Scene();
  private readonly camera = new THREE.PerspectiveCamera(FIELD, 1, 0.1, 1e5);
  private readonly ribbon: Ribbon | null;
  private readonly tool = new THREE.Group();
  private readonly housing = new THREE.Group(); // round the tool, and not deflected with it
  private readonly links = new THREE.Group();
  private readonly bodies: THREE.Mesh[] = [];
  private readonly marker: THREE.Mesh;
  private readonly sphere = new THREE.Sphere();
  private readonly box = new THREE.Box3();
  private near: Nearest | null = null; // made when something is first pointed at
  private queued = false;
  private disposed = false;
  private sample = 0;
  magnified: number;
  onDrawn: (() => void) | null = null;

  constructor(private readonly run: Run, private readonly other: Run | null, readonly canvas: HTMLCanvasElement) {
    this.renderer = new THREE.WebGLRenderer({ canvas, antialias: true, alpha: true, preserveDrawingBuffer: false });
    this.renderer.setClearColor(0x000000, 0);
    this.renderer.outputColorSpace = THREE.LinearSRGBColorSpace;
    this.renderer.setPixelRatio(Math.min(2, window.devicePixelRatio || 1));
    this.camera.up.set(0, 0, 1);
    this.controls = new OrbitControls(this.camera, canvas);
    this.controls.addEventListener("change", () => this.invalidate());
    this.magnified = run.header.deflection?.k ?? 1;
    this.map = run.header.scene.map ? new HeightMap(run) : null;
    if (this.map) this.scene.add(this.map.object);
    this.addSurfaces();
    this.addGhosts();
    this.addOutlines();
    this.ribbon = run.header.scene.path ? new Ribbon(run) : null;
    if (this.ribbon) this.scene.add(this.ribbon.object);
    this.addTool();
    this.scene.add(this.links);
    this.marker = new THREE.Mesh(new THREE.SphereGeometry(1, 24, 16), bodyMaterial({ tint: 0xffd23f, smooth: true }));
    this.scene.add(this.marker);
    this.measure();
    this.marker.scale.setScalar(Math.max(1e-3, 0.008 * this.sphere.radius));
    canvas.addEventListener("webglcontextlost", (event) => {
      event.preventDefault();
      if (this.disposed) return;
      canvas.dispatchEvent(new CustomEvent("lost", { bubbles: true }));
    });
  }

  private addSurfaces(): void {
    const { file } = this.run;
    this.run.header.scene.surfaces.forEach((surface, k) => {
      const geometry = new THREE.BufferGeometry();
      geometry.setAttribute("position", new THREE.BufferAttribute(file.raw(`s/${k}/point`) as Float32Array, 3));
      geometry.setIndex(new THREE.BufferAttribute(file.raw(`s/${k}/corner`) as Uint32Array, 1));
      const { tint, opacity } = TINTS[surface.tint] ?? TINTS.work;
      const choice = surface.coloured ? this.run.header.colour.choices[surface.coloured] : undefined;
      if (choice) {
        const values = file.values(`s/${k}/value`);
        geometry.setAttribute("value", new THREE.BufferAttribute(Float32Array.from(values, (v) => (Number.isNaN(v) ? -3e38 : v)), 1));
      }
      const table = choice ? tableTexture(this.run.table(choice)) : undefined;
      const mesh = new THREE.Mesh(geometry, bodyMaterial({ tint, opacity, table, low: choice?.low, high: choice?.high }));
      mesh.name = surface.title;
      mesh.userData.surface = k;
      this.scene.add(mesh);
      this.bodies.push(mesh);
      if (geometry.index!.count < 600_000 && (opacity >= 1 || surface.tint === "glass")) {
        const faces = file.has(`s/${k}/face`) ? (file.raw(`s/${k}/face`) as Uint32Array) : null;
        const lines = new THREE.LineSegments(faces ? borders(geometry, faces) : new THREE.EdgesGeometry(welded(geometry), EDGE), new THREE.LineBasicMaterial({ color: 0x39424d }));
        this.scene.add(lines);
      }
    });
  }

  /** What the other run left, in grey: only surfaces that carry a result. */
  private addGhosts(): void {
    if (!this.other || this.other.header.process !== this.run.header.process) return;
    this.other.header.scene.surfaces.forEach((surface, k) => {
      if (!surface.coloured) return;
      const geometry = new THREE.BufferGeometry();
      geometry.setAttribute("position", new THREE.BufferAttribute(this.other!.file.raw(`s/${k}/point`) as Float32Array, 3));
      geometry.setIndex(new THREE.BufferAttribute(this.other!.file.raw(`s/${k}/corner`) as Uint32Array, 1));
      const mesh = new THREE.Mesh(geometry, bodyMaterial(TINTS.ghost));
      mesh.renderOrder = 1;
      this.scene.add(mesh);
    });
  }

  /** The camera as it stands, so that the next run is seen from the same place. */
  get stand(): { position: THREE.Vector3; target: THREE.Vector3 } {
    return { position: this.camera.position.clone(), target: this.controls.target.clone() };
  }

  standAt({ position, target }: { position: THREE.Vector3; target: THREE.Vector3 }): void {
    this.camera.position.copy(position);
    this.controls.target.copy(target);
    this.controls.update();
    this.invalidate();
  }

  /** Gives the context back: a page has few of them. */
  dispose(): void {
    this.disposed = true;
    this.controls.dispose();
    this.renderer.dispose();
    this.renderer.forceContextLoss();
  }

  private addOutlines(): void {
    for (let k = 0; k < this.run.header.scene.outlines; k++) {
      const geometry = new THREE.BufferGeometry();
      geometry.setAttribute("position", new THREE.BufferAttribute(this.run.file.raw(`o/${k}`) as Float32Array, 3));
      this.scene.add(new THREE.Line(geometry, new THREE.LineBasicMaterial({ color: 0x7b8794 })));
    }
  }

  private addTool(): void {
    this.run.header.tools.forEach((given, k) => {
      const tool = turned(given);
      const solid = bodied(this.run.file, k, given);
      if (solid.length) tool.add(...solid);
      this.tool.add(tool);
      this.housing.add(housed(given));
    });
    this.scene.add(this.tool, this.housing);
  }

  /** What the view is centred on: part and stock, else the path. */
  private measure(): void {
    const box = this.box;
    box.makeEmpty();
    if (this.map) box.union(this.map.box);
    for (const body of this.bodies) {
      if (["machine", "robot"].includes(this.run.header.scene.surfaces[body.userData.surface as number].tint)) continue;
      body.geometry.computeBoundingBox();
      box.union(body.geometry.boundingBox!);
    }
    const cuts = (i: number) => !this.run.kind || this.run.kind[i] !== 0;
    if (box.isEmpty()) for (let i = 0; i < this.run.count; i++) if (cuts(i)) box.expandByPoint(new THREE.Vector3(...this.run.at(i)));
    if (box.isEmpty()) box.expandByPoint(new THREE.Vector3(...this.run.at(0)));
    const { focus } = this.run.header.scene;
    if (focus) box.set(new THREE.Vector3().fromArray(focus[0]), new THREE.Vector3().fromArray(focus[1]));
    box.getBoundingSphere(this.sphere);
    this.sphere.radius = Math.max(this.sphere.radius, 1e-3);
  }

  /** Sets the size of the picture in CSS pixels. */
  resize(width: number, height: number): void {
    if (width < 2 || height < 2) return;
    this.renderer.setSize(width, height, false);
    this.camera.aspect = width / height;
    this.camera.updateProjectionMatrix();
    const ratio = this.renderer.getPixelRatio();
    shared.viewport.value.set(width * ratio, height * ratio);
    this.setWidth();
    this.invalidate();
  }

  private width = 2.5;

  setWidth(pixels = this.width): void {
    this.width = pixels;
    const material = this.ribbon?.object.material as THREE.ShaderMaterial | undefined;
    if (material) {
      material.uniforms.width.value = pixels * this.renderer.getPixelRatio();
      material.uniforms.casing.value = 1.0 * this.renderer.getPixelRatio();
    }
    this.invalidate();
  }

  look(preset: Preset, sample = this.sample): void {
    const front = new THREE.Vector3(...this.run.header.scene.front);
    const right = new THREE.Vector3(-front.y, front.x, 0).normalize();
    const up = new THREE.Vector3(0, 0, 1);
    const centre = this.sphere.center.clone();
    let radius = this.sphere.radius;
    const oblique = () => front.clone().multiplyScalar(0.85).addScaledVector(right, 0.65).addScaledVector(up, 0.8);
    const from: Record<Preset, () => THREE.Vector3> = {
      fit: oblique,
      all: oblique,
      iso: oblique,
      top: () => up.clone().addScaledVector(front, 1e-4),
      front: () => front.clone(),
      right: () => right.clone(),
      tool: () => front.clone().multiplyScalar(0.85).addScaledVector(right, 0.65).addScaledVector(up, 0.55),
      worst: () => front.clone().multiplyScalar(0.6).addScaledVector(right, 0.5).addScaledVector(up, 1.0),
    };
    if (preset === "tool" || preset === "worst") {
      centre.set(...this.run.at(sample));
      const radii = this.run.header.tools.flatMap((tool) => tool.cutter.map(([, r]) => r));
      const wide = radii.length ? Math.max(...radii) : 0.1 * radius;
      radius = Math.min(radius, Math.max(2.5 * wide, 1e-3));
    }
    const box = this.box.clone();
    if (preset === "all") {
      for (const p of this.linkPoints(sample)) box.expandByPoint(p);
      const whole = box.getBoundingSphere(new THREE.Sphere());
      centre.copy(whole.center);
      radius = whole.radius;
    }
    const half = (FIELD / 2) * (Math.PI / 180);
    const narrow = Math.min(half, Math.atan(this.camera.aspect * Math.tan(half)));
    const way = from[preset]().normalize();
    let distance = (1.1 * radius) / Math.sin(narrow);
    if (preset === "fit" || preset === "all") distance = Math.min(distance, this.fitting(box, centre, way));
    this.camera.position.copy(centre).addScaledVector(way, distance);
    this.camera.near = distance / 200;
    this.camera.far = distance * 20 + 20 * this.sphere.radius;
    this.camera.updateProjectionMatrix();
    this.controls.target.copy(centre);
    this.controls.update();
    this.invalidate();
  }

  /** From how far the box of what is looked at fills the picture, seen from a direction. */
  private fitting(box: THREE.Box3, centre: THREE.Vector3, way: THREE.Vector3): number {
    const right = new THREE.Vector3().crossVectors(this.camera.up, way).normalize();
    const over = new THREE.Vector3().crossVectors(way, right);
    const tall = Math.tan((FIELD / 2) * (Math.PI / 180)) * FILLED;
    const wide = tall * this.camera.aspect;
    let least = 0;
    for (let k = 0; k < 8; k++) {
      const corner = new THREE.Vector3(k & 1 ? box.max.x : box.min.x, k & 2 ? box.max.y : box.min.y, k & 4 ? box.max.z : box.min.z).sub(centre);
      const near = corner.dot(way);
      least = Math.max(least, near + Math.abs(corner.dot(right)) / wide, near + Math.abs(corner.dot(over)) / tall);
    }
    return Math.max(least, 1e-3);
  }

  get distance(): number {
    return this.camera.position.distanceTo(this.controls.target);
  }

  colour(name: string): void {
    this.ribbon?.colour(this.run.histories.get(name));
    this.invalidate();
  }

  showTool(on: boolean): void {
    this.tool.visible = on;
    this.housing.visible = on;
    this.links.visible = on;
    this.marker.visible = on;
    this.invalidate();
  }

  get toolShown(): boolean {
    return this.tool.visible;
  }

  clip(axis: "none" | "x" | "y" | "z" | "view", share: number): void {
    const clip = shared.clip.value;
    if (axis === "none") clip.set(0, 0, 0, 1);
    else {
      const n = axis === "view" ? this.camera.position.clone().sub(this.controls.target).normalize() : new THREE.Vector3(Number(axis === "x"), Number(axis === "y"), Number(axis === "z"));
      const reach = axis === "view" ? this.sphere.radius : 0.5 * this.box.getSize(new THREE.Vector3()).dot(n) + 1e-6;
      clip.set(n.x, n.y, n.z, this.sphere.center.dot(n) + reach * (2 * share - 1));
    }
    this.invalidate();
  }

  goto(i: number): void {
    this.sample = i;
    shared.now.value = i;
    const place = new THREE.Vector3(...this.run.at(i));
    const off = new THREE.Vector3(...this.run.deflectionAt(i)).multiplyScalar(this.magnified);
    this.tool.position.copy(place).add(off);
    const axis = new THREE.Vector3(...this.run.axisAt(i)).normalize();
    const up = new THREE.Vector3(0, 0, 1);
    const mounted = this.run.tool ? this.run.tool[i] : 0;
    const { pivot } = this.run.header.tools[mounted] ?? { pivot: 0 };
    const leaning = pivot > 0 ? axis.clone().multiplyScalar(pivot).sub(off).normalize() : axis; // from the deflected tip to the joint
    this.tool.quaternion.setFromUnitVectors(up, leaning);
    this.housing.position.copy(place);
    this.housing.quaternion.setFromUnitVectors(up, axis);
    this.marker.position.copy(place);
    for (const group of [this.tool, this.housing]) group.children.forEach((one, k) => (one.visible = k === mounted));
    this.moveLinks(i);
    this.invalidate();
  }

  private linkRow = -1;

  private linkPoints(i: number): THREE.Vector3[] {
    const shape = this.run.header.scene.links;
    if (!shape) return [];
    const first = (this.run.file.raw("link_of") as Uint32Array)[i] * shape[1];
    const all = this.run.file.raw("links") as Float32Array;
    return Array.from({ length: shape[1] }, (_, k) => new THREE.Vector3().fromArray(all, 3 * (first + k)));
  }

  /** Joints and what lies between them, where something carries the tool. */
  private moveLinks(i: number): void {
    const shape = this.run.header.scene.links;
    if (!shape) return;
    const row = (this.run.file.raw("link_of") as Uint32Array)[i];
    if (row === this.linkRow) return;
    this.linkRow = row;
    const at = this.linkPoints(i);
    this.links.clear();
    this.links.add(this.run.header.scene.links_are === "arm" ? arm(at) : bodies(at));
  }

  invalidate(): void {
    if (this.queued) return;
    this.queued = true;
    requestAnimationFrame(() => {
      this.queued = false;
      if (!this.disposed) this.render();
    });
  }

  render(): void {
    const pixels = this.renderer.domElement.height / (2 * Math.tan((FIELD / 2) * (Math.PI / 180)) * Math.max(1e-9, this.distance));
    this.map?.refine(pixels);
    this.renderer.render(this.scene, this.camera);
    this.onDrawn?.();
  }

  /** A place in pixels of the page. */
  projected(place: [number, number, number]): { x: number; y: number; depth: number } {
    this.camera.updateMatrixWorld();
    const p = new THREE.Vector3(...place).project(this.camera);
    const box = this.canvas.getBoundingClientRect();
    return { x: box.left + ((p.x + 1) / 2) * box.width, y: box.top + ((1 - p.y) / 2) * box.height, depth: p.z };
  }

  /** The nearest sample within 12 px of a point of the page; else what the ray meets first. */
  pick(point: { clientX: number; clientY: number }): Picked | null {
    const near = this.run.header.scene.path ? this.nearestSample(point) : null;
    if (near !== null) return { sample: near, place: this.run.at(near), name: "" };
    const box = this.canvas.getBoundingClientRect();
    const caster = new THREE.Raycaster();
    const at = new THREE.Vector2(((point.clientX - box.left) / box.width) * 2 - 1, 1 - ((point.clientY - box.top) / box.height) * 2);
    caster.setFromCamera(at, this.camera);
    const cut = this.map?.hit(caster.ray) ?? null;
    const body = caster.intersectObjects(this.bodies, false)[0];
    if (cut && (!body || caster.ray.origin.distanceTo(cut.point) <= body.distance)) {
      return { sample: cut.sample, place: cut.point.toArray(), name: "stock" };
    }
    if (!body) return null;
    return { sample: this.nearest.inSpace(body.point), place: body.point.toArray(), name: this.nameOf(body) };
  }

  private nameOf(hit: THREE.Intersection): string {
    const k = hit.object.userData.surface as number;
    const surface = this.run.header.scene.surfaces[k];
    if (!this.run.file.has(`s/${k}/face`)) return surface.title;
    const face = (this.run.file.raw(`s/${k}/face`) as Uint32Array)[hit.faceIndex ?? 0];
    return surface.faces[String(face)] ?? `face:${face}`;
  }

  private nearestSample(point: { clientX: number; clientY: number }): number | null {
    this.camera.updateMatrixWorld();
    const box = this.canvas.getBoundingClientRect();
    const m = new THREE.Matrix4().multiplyMatrices(this.camera.projectionMatrix, this.camera.matrixWorldInverse).elements;
    const half = { x: box.width / 2, y: box.height / 2 };
    return this.nearest.onScreen(m, point.clientX - box.left - half.x, half.y + box.top - point.clientY, half, NEAR_PIXELS);
  }

  private get nearest(): Nearest {
    return (this.near ??= new Nearest(this.run));
  }

  /** The picture as it stands, row by row from below. */
  pixels(): { width: number; height: number; data: Uint8Array } {
    this.renderer.render(this.scene, this.camera);
    const gl = this.renderer.getContext();
    const { drawingBufferWidth: width, drawingBufferHeight: height } = gl;
    const data = new Uint8Array(4 * width * height);
    gl.readPixels(0, 0, width, height, gl.RGBA, gl.UNSIGNED_BYTE, data);
    return { width, height, data };
  }

  /** The picture at twice its size. */
  picture(): HTMLCanvasElement {
    const ratio = this.renderer.getPixelRatio();
    const size = this.renderer.getSize(new THREE.Vector2());
    this.renderer.setPixelRatio(2 * ratio);
    this.resize(size.x, size.y);
    this.renderer.render(this.scene, this.camera);
    const copy = document.createElement("canvas");
    copy.width = this.canvas.width;
    copy.height = this.canvas.height;
    copy.getContext("2d")!.drawImage(this.canvas, 0, 0);
    this.renderer.setPixelRatio(ratio);
    this.resize(size.x, size.y);
    return copy;
  }
}

/** Edges between triangles of different faces, and free ones: outlines of a part whatever its triangles are like. */
function borders(geometry: THREE.BufferGeometry, faces: Uint32Array): THREE.BufferGeometry {
  const corner = geometry.index!.array as Uint32Array;
  const count = geometry.getAttribute("position").count;
  const known = new Map<number, number>();
  for (let t = 0; t < faces.length; t++) {
    for (let e = 0; e < 3; e++) {
      const [a, b] = [corner[3 * t + e], corner[3 * t + ((e + 1) % 3)]];
      const key = Math.min(a, b) * count + Math.max(a, b);
      const face = known.get(key);
      if (face === undefined) known.set(key, faces[t]);
      else if (face === faces[t]) known.set(key, INNER);
    }
  }
  const ends: number[] = [];
  for (const [key, face] of known) if (face !== INNER) ends.push(Math.floor(key / count), key % count);
  const lines = new THREE.BufferGeometry();
  lines.setAttribute("position", geometry.getAttribute("position"));
  lines.setIndex(ends);
  return lines;
}
