#pragma once

namespace rigcal {

/// `straight` looks ahead and sees nothing but upright walls; `down` looks down at the floor.
inline constexpr const char* court_rig = R"(rigcal: 1
name: court
base: avia
sensors:
  avia: {type: livox_avia, broadcast_code: "3JEDHC900100791", ip: 192.168.1.179}
  straight: {type: livox_mid40, broadcast_code: "0TFDG3B00600551", ip: 192.168.1.21}
  down: {type: livox_mid40, broadcast_code: "0TFDG3B00600552", ip: 192.168.1.22}
initial_extrinsics:
  straight: {translation: [-0.15, 0.0, -0.15], rotation_xyzw: [0.0, 0.0, 0.258819, 0.965926]}
  down: {translation: [-0.15, 0.0, -0.15], rotation_xyzw: [0.0, 0.258819, 0.0, 0.965926]}
turntable: {driver: manual, axis: [0, 0, 1]}
)";

/// Walls some 3 m away, low things on the floor and others high up: a narrow view straight ahead shows walls only.
inline constexpr const char* court_scene = R"(rigcal: 1
name: court
materials:
  wall: {reflectivity: 60}
  floor: {reflectivity: 35}
turntable: {position: [0.2, -0.1, 1.8], yaw_deg: 12}
ground: {height: 0, material: floor}
objects:
  - {shape: panel, corner: [3.4, -2.6, 0], edge_a: [0.2, 5.0, 0], edge_b: [0, 0, 7], material: wall}
  - {shape: panel, corner: [3.6, 2.4, 0], edge_a: [-3.0, 1.4, 0], edge_b: [0, 0, 7], material: wall}
  - {shape: panel, corner: [0.6, 3.8, 0], edge_a: [-4.0, -1.5, 0], edge_b: [0, 0, 7], material: wall}
  - {shape: panel, corner: [-3.4, 2.3, 0], edge_a: [0.3, -4.6, 0], edge_b: [0, 0, 7], material: wall}
  - {shape: panel, corner: [-3.1, -2.3, 0], edge_a: [6.5, -0.3, 0], edge_b: [0, 0, 7], material: wall}
  - {shape: box, center: [2.6, 1.2, 0.2], size: [0.8, 0.5, 0.4], rpy_deg: [0, 0, 25], material: wall}
  - {shape: box, center: [2.5, -1.4, 0.2], size: [0.7, 0.6, 0.4], rpy_deg: [0, 0, -20], material: wall}
  - {shape: box, center: [-2.3, 1.2, 0.15], size: [0.6, 0.9, 0.3], rpy_deg: [0, 0, -35], material: wall}
  - {shape: box, center: [-2.2, -1.2, 0.2], size: [0.9, 0.5, 0.4], rpy_deg: [0, 0, 55], material: wall}
  - {shape: box, center: [0.4, -2.0, 0.18], size: [1.2, 0.4, 0.36], rpy_deg: [0, 0, 10], material: wall}
  - {shape: box, center: [0.6, 2.6, 0.18], size: [1.0, 0.5, 0.36], rpy_deg: [0, 0, -12], material: wall}
  - {shape: box, center: [3.2, 0.4, 3.6], size: [0.8, 1.4, 0.3], rpy_deg: [0, 12, 4], material: wall}
  - {shape: box, center: [1.7, 2.9, 3.7], size: [1.4, 0.8, 0.3], rpy_deg: [10, 0, -25], material: wall}
  - {shape: box, center: [-1.6, 2.6, 3.5], size: [1.5, 0.8, 0.3], rpy_deg: [8, 0, 21], material: wall}
  - {shape: box, center: [-2.9, -0.4, 3.6], size: [0.8, 1.3, 0.3], rpy_deg: [0, -10, 3], material: wall}
  - {shape: box, center: [0.6, -2.2, 3.4], size: [1.6, 0.7, 0.3], rpy_deg: [-10, 0, -2], material: wall}
)";

}  // namespace rigcal
