// aedes, a broker that we did not write, on a free port of 127.0.0.1.
//   aedes_broker.mjs [USER PASSWORD]
// Lets in that user only when one is named. Nobody may publish or subscribe to what begins with
// `forbidden/`. Prints `listening on PORT`; ends on SIGTERM.
import net from "node:net";
import aedes from "aedes";

const [user, password] = process.argv.slice(2);
const forbidden = (topic) => topic.startsWith("forbidden/");
const broker = aedes({
  authenticate: (client, name, secret, done) =>
    user === undefined || (name === user && String(secret) === password)
      ? done(null, true)
      : done(Object.assign(new Error("bad user name or password"), { returnCode: 4 }), false),
  authorizePublish: (client, packet, done) => done(forbidden(packet.topic) ? new Error("forbidden") : null),
  authorizeSubscribe: (client, subscription, done) => done(null, forbidden(subscription.topic) ? null : subscription),
});

const server = net.createServer(broker.handle);
server.listen(0, "127.0.0.1", () => console.log(`listening on ${server.address().port} `));
