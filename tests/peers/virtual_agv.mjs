// A virtual AGV of vda-5050-lib, a robot that we did not write.
//   virtual_agv.mjs BROKER_URL VERSION MANUFACTURER SERIAL_NUMBER [STATE_INTERVAL]
// VERSION is 1.1.0 or 2.0.0, STATE_INTERVAL in ms, 30,000 otherwise. Prints `online` when it is connected, ends on SIGTERM or SIGINT.
import vda from "vda-5050-lib";

const [brokerUrl, vdaVersion, manufacturer, serialNumber, interval] = process.argv.slice(2);
const agv = new vda.AgvController(
  { manufacturer, serialNumber },
  { interfaceName: "uagv", transport: { brokerUrl }, vdaVersion },
  {
    agvAdapterType: vda.VirtualAgvAdapter,
    ...(interval && { publishStateInterval: Number(interval) }),
  },
  {},
);

for (const signal of ["SIGTERM", "SIGINT"]) {
  process.on(signal, async () => {
    await agv.stop();
    process.exit(0);
  });
}

await agv.start();
console.log("online");
