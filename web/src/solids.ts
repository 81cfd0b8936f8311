// Bodies that are made here and not in the run: turned tools, the spindle round them, what carries them.
import * as THREE from "three";
import { Turned, ViewFile } from "./file";
import { bodyMaterial } from "./shaders";

export const EDGE = 25; // degrees over which an outline is drawn
const STEEL = 0x3d5a80;
const GOLD = 0xc9a227;
const HOLDER = 0x6b7480;
const HOUSING = 0x8fa3b8;
const ARM = 0xd9741f;
const JOINT = 0x4a5560;
const BODIES = [0x8fa3b8, 0xa9b8a0, 0xc2a98c, 0x9c9fc0, 0x8db5b3];

/** A tool by its profiles, turned about its axis. */
export function turned(given: Turned): THREE.Group {
  const group = new THREE.Group();
  for (const [profile, tint] of [[given.cutter, STEEL], [given.holder, HOLDER]] as const) {
    if (profile.length >= 2) group.add(...outlined(lathe(profile), tint, 0.5));
  }
  return group;
}

/** What is not turned of a tool: an insert, and what holds it. */
export function bodied(file: ViewFile, k: number, given: Turned): THREE.Object3D[] {
  return given.bodies.flatMap((holds, n) => {
    const geometry = new THREE.BufferGeometry();
    geometry.setAttribute("position", new THREE.BufferAttribute(file.raw(`t/${k}/${n}/point`) as Float32Array, 3));
    geometry.setIndex(new THREE.BufferAttribute(file.raw(`t/${k}/${n}/corner`) as Uint32Array, 1));
    return outlined(geometry, holds ? HOLDER : GOLD, holds ? 0.5 : 0.9);
  });
}

/** What stands still round a tool: the housing of a compliant spindle, and its pistons. */
export function housed(given: Turned): THREE.Group {
  const group = new THREE.Group();
  if (given.fixed.length >= 2) group.add(...outlined(lathe(given.fixed), HOUSING, 0.16));
  const material = bodyMaterial({ tint: JOINT, opacity: 0.7, smooth: true });
  for (const [x0, y0, z0, x1, y1, z1, radius] of given.rods) group.add(rod(new THREE.Vector3(x0, y0, z0), new THREE.Vector3(x1, y1, z1), radius, radius, material));
  return group;
}

/** An arm by its joints: tapered links, a drum at each joint. */
export function arm(at: THREE.Vector3[]): THREE.Group {
  const group = new THREE.Group();
  const reach = lengthOf(at);
  const link = bodyMaterial({ tint: ARM, opacity: 0.8, smooth: true });
  const drum = bodyMaterial({ tint: JOINT, opacity: 0.9, smooth: true });
  const wide = (k: number) => Math.max(0.03 * reach * (1 - (0.75 * k) / (at.length - 1)), 1e-6);
  const last = at.length - 1;
  at.forEach((p, k) => {
    if (k === 0) return;
    if (p.distanceTo(at[k - 1]) < 1e-6) return;
    group.add(rod(at[k - 1], p, wide(k - 1), k === last ? 0.15 * wide(k) : 0.85 * wide(k), link));
    if (k < last) {
      const joint = new THREE.Mesh(new THREE.SphereGeometry(1.15 * wide(k), 24, 16), drum);
      joint.position.copy(p);
      group.add(joint);
    }
  });
  const foot = new THREE.Mesh(new THREE.CylinderGeometry(1.5 * wide(0), 1.7 * wide(0), 0.04 * reach, 32).rotateX(Math.PI / 2), drum);
  foot.position.copy(at[0]);
  group.add(foot);
  return group;
}

/** Bodies of a machine: a box from joint to joint, each of its own tint. */
export function bodies(at: THREE.Vector3[]): THREE.Group {
  const group = new THREE.Group();
  const reach = lengthOf(at);
  for (let k = 1; k < at.length; k++) {
    const way = at[k].clone().sub(at[k - 1]);
    const long = way.length();
    if (long < 1e-3 * reach) continue;
    const wide = Math.max(0.02 * reach, Math.min(0.06 * reach, 0.25 * long)) * (1 - (0.5 * (k - 1)) / at.length);
    const box = new THREE.BoxGeometry(wide, long, wide);
    const place = at[k - 1].clone().addScaledVector(way, 0.5);
    const turn = new THREE.Quaternion().setFromUnitVectors(new THREE.Vector3(0, 1, 0), way.normalize());
    for (const one of outlined(box, BODIES[(k - 1) % BODIES.length], 0.35)) {
      one.position.copy(place);
      one.quaternion.copy(turn);
      group.add(one);
    }
  }
  return group;
}

function lengthOf(at: THREE.Vector3[]): number {
  return at.slice(1).reduce((sum, p, k) => sum + p.distanceTo(at[k]), 0);
}

function rod(from: THREE.Vector3, to: THREE.Vector3, first: number, last: number, material: THREE.Material): THREE.Mesh {
  const way = to.clone().sub(from);
  const mesh = new THREE.Mesh(new THREE.CylinderGeometry(last, first, way.length(), 24), material);
  mesh.position.copy(from).addScaledVector(way, 0.5);
  mesh.quaternion.setFromUnitVectors(new THREE.Vector3(0, 1, 0), way.normalize());
  return mesh;
}

function lathe(profile: [number, number][]): THREE.BufferGeometry {
  const made = new THREE.LatheGeometry(profile.map(([z, r]) => new THREE.Vector2(Math.max(r, 0), z)), 48);
  return made.rotateX(Math.PI / 2);
}

function outlined(geometry: THREE.BufferGeometry, tint: number, opacity: number): THREE.Object3D[] {
  const mesh = new THREE.Mesh(geometry, bodyMaterial({ tint, opacity }));
  mesh.renderOrder = 3;
  const dark = new THREE.LineBasicMaterial({ color: 0x1c2733, transparent: true, opacity: Math.min(0.6, 2 * opacity) });
  return [mesh, new THREE.LineSegments(new THREE.EdgesGeometry(welded(geometry), EDGE), dark)];
}

/** Without normals, so that neighbouring triangles share their corners and smooth surfaces have no outlines. */
export function welded(geometry: THREE.BufferGeometry): THREE.BufferGeometry {
  const bare = new THREE.BufferGeometry();
  bare.setAttribute("position", geometry.getAttribute("position"));
  bare.setIndex(geometry.index);
  return bare;
}
