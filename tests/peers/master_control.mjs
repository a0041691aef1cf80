// The master control of vda-5050-lib, which we did not write, drives robots through random orders.
//   master_control.mjs BROKER_URL VERSION MANUFACTURER ROBOTS ORDERS
// VERSION is 1.1.0 or 2.0.0; the robots are 0001 to ROBOTS, and each gets so many orders. Some end
// with their base and are extended there, some on the way. Prints `driven: ORDERS orders, UPDATES
// updates` when all of them have been driven to their ends, or what went wrong, and ends.
import vda from "vda-5050-lib";

const [brokerUrl, vdaVersion, manufacturer, robots, orders] = process.argv.slice(2);
const master = new vda.MasterController(
  { interfaceName: "uagv", transport: { brokerUrl }, vdaVersion },
  {},
);

let seed = 1;
function random(below) {
  seed = (Math.imul(seed, 1103515245) + 12345) >>> 0;
  return (seed >>> 16) % below;
}

let actionCount = 0;
function randomActions() {
  return Array.from({ length: random(3) }, () => ({
    actionId: `a${++actionCount}`,
    actionType: random(2) ? "detectObject" : "finePositioning",
    blockingType: ["NONE", "SOFT", "HARD"][random(3)],
    actionParameters: [],
  }));
}

// A graph of so many edges behind this node; nothing is released yet.
function randomLegs(from, count) {
  const nodes = [];
  const edges = [];
  for (let i = 1; i <= count; ++i) {
    const start = i === 1 ? from : nodes[i - 2];
    const node = {
      nodeId: `n${random(5)}`,
      sequenceId: from.sequenceId + 2 * i,
      released: false,
      actions: randomActions(),
    };
    edges.push({
      edgeId: `${start.nodeId}-${node.nodeId}`,
      sequenceId: node.sequenceId - 1,
      released: false,
      startNodeId: start.nodeId,
      endNodeId: node.nodeId,
      actions: randomActions(),
    });
    nodes.push(node);
  }
  return { nodes, edges };
}

function release({ nodes, edges }, count) {
  nodes.slice(0, count).forEach((node) => { node.released = true; });
  edges.slice(0, count).forEach((edge) => { edge.released = true; });
}

let updates = 0;

// Resolves to the node where the robot stands at the end.
function drive(serialNumber, orderId, startId) {
  const agvId = { manufacturer, serialNumber };
  return new Promise((resolve, reject) => {
    const first = { nodeId: startId, sequenceId: 0, released: true, actions: randomActions() };
    let base = [first]; // all nodes released so far
    let orderUpdateId = 0;
    let updatesLeft = random(3);
    const expected = new Set();
    const visited = [];

    function send(stitch, legs) {
      const released = legs.nodes.filter((node) => node.released);
      const stitched = base.length > 1 || orderUpdateId > 0 ? { ...stitch } : stitch;
      base = base.concat(released);
      const edges = legs.edges.filter((edge) => edge.released);
      for (const leg of [stitch, ...released, ...edges]) {
        leg.actions.forEach((action) => expected.add(action.actionId));
      }
      const order = { orderId, orderUpdateId, nodes: [stitched, ...legs.nodes], edges: legs.edges };
      master.assignOrder(agvId, order, handler).catch(reject);
    }
    // The last update has no horizon.
    function extend() {
      const end = base[base.length - 1];
      const legs = randomLegs(end, 1 + random(3));
      ++orderUpdateId;
      --updatesLeft;
      ++updates;
      release(legs, updatesLeft > 0 ? 1 : legs.nodes.length);
      send(end, legs);
    }
    const finished = new Set();
    const handler = {
      onNodeTraversed: (node) => {
        // An update of an order that has ended begins with its last node again.
        if (visited.at(-1) !== node.sequenceId) visited.push(node.sequenceId);
        if (updatesLeft > 0 && random(2)) extend();
      },
      onActionStateChanged: (state, error) => {
        if (state.actionStatus === "FAILED") reject(new Error(`${state.actionId} failed: ${error}`));
        if (state.actionStatus === "FINISHED") finished.add(state.actionId);
      },
      onOrderProcessed: (error, byCancelation, active, { state, order }) => {
        if (error) return reject(new Error(JSON.stringify(error)));
        if (order.orderUpdateId !== orderUpdateId) return undefined; // extended meanwhile
        if (updatesLeft > 0) return extend();
        const end = base[base.length - 1];
        const problems = [];
        if (active) problems.push("a horizon is left");
        if (state.lastNodeId !== end.nodeId) problems.push(`${state.lastNodeId} is the last node`);
        if (state.lastNodeSequenceId !== end.sequenceId) problems.push("of another sequenceId");
        if (state.driving) problems.push("it is driving");
        if (visited.join() !== base.map((node) => node.sequenceId).join()) {
          problems.push(`visited ${visited}`);
        }
        for (const id of expected) if (!finished.has(id)) problems.push(`${id} is not FINISHED`);
        if (problems.length > 0) return reject(new Error(`${orderId}: ${problems.join(", ")}`));
        return resolve(end.nodeId);
      },
    };
    const legs = randomLegs(first, 1 + random(4));
    release(legs, updatesLeft > 0 ? 1 : legs.nodes.length);
    send(first, legs);
  });
}

async function driveAll(serialNumber) {
  let node = "n0";
  for (let i = 0; i < Number(orders); ++i) {
    node = await drive(serialNumber, `${serialNumber}-${i}`, node);
  }
}

await master.start();
try {
  const serialNumbers = Array.from({ length: Number(robots) }, (_, i) =>
    String(i + 1).padStart(4, "0"));
  await Promise.all(serialNumbers.map(driveAll));
  console.log(`driven: ${robots * orders} orders, ${updates} updates`);
} catch (error) {
  console.log(`not driven: ${error.message}`);
}
await master.stop();
process.exit(0);
