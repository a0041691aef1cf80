// Writes states of about 2 KB, one per line: a robot under way with an order.
//   state_lines.mjs FILE COUNT
import { writeFileSync } from "node:fs";
const [file, count] = process.argv.slice(2);
const lines = [];
for (let i = 0; i < Number(count); ++i) {
  const at = (n) => ({ x: 10.25 + n, y: 3.5 * n, mapId: "map-1", theta: 0.7853 });
  lines.push(JSON.stringify({
    headerId: i, timestamp: "2026-01-02T03:04:05.678Z", version: "3.0.0", manufacturer: "KIT", serialNumber: "0001",
    maps: [{ mapId: "map-1", mapVersion: "1", mapStatus: "ENABLED" }],
    orderId: `order-${i}`, orderUpdateId: 3, lastNodeId: "node-17", lastNodeSequenceId: 34,
    nodeStates: [0, 1, 2, 3].map((n) => ({ nodeId: `node-${18 + n}`, sequenceId: 36 + 2 * n, released: n < 2, nodePosition: at(n) })),
    edgeStates: [0, 1, 2, 3].map((n) => ({ edgeId: `edge-${17 + n}`, sequenceId: 35 + 2 * n, released: n < 2 })),
    mobileRobotPosition: { ...at(0.4), localized: true, localizationScore: 0.97 },
    velocity: { vx: 0.8, vy: 0, omega: 0.02 }, loads: [{ loadId: "pallet-9", loadType: "EPAL", weight: 312.5 }],
    driving: true, paused: false, newBaseRequest: false, distanceSinceLastNode: 2.75,
    actionStates: [0, 1, 2].map((n) => ({ actionId: `9f1c2a3b-0000-4000-8000-00000000000${n}`, actionType: "pick", actionStatus: "WAITING", actionDescriptor: "At the station" })),
    instantActionStates: [{ actionId: "9f1c2a3b-0000-4000-8000-000000000009", actionType: "startPause", actionStatus: "FINISHED" }],
    powerSupply: { stateOfCharge: 81.5, batteryVoltage: 48.2, charging: false }, operatingMode: "AUTOMATIC",
    errors: [{ errorType: "lowBattery", errorLevel: "WARNING", errorReferences: [{ referenceKey: "orderId", referenceValue: "order" }], errorDescription: "Charge soon" }],
    information: [], safetyState: { activeEmergencyStop: "NONE", fieldViolation: false },
  }));
}
writeFileSync(file, lines.join("\n") + "\n");
