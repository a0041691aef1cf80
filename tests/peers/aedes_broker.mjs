// aedes, a broker that we did not write, on two ports of 127.0.0.1: MQTT, and MQTT in WebSockets.
//   aedes_broker.mjs PORT WEBPORT [USER PASSWORD]
// 0 is a free port.
// Lets in that user only when one is named. Nobody may publish or subscribe to what begins with
// `forbidden/`. Prints `listening on PORT WEBPORT`; ends on SIGTERM.
import http from "node:http";
import net from "node:net";
import aedes from "aedes";
import { createWebSocketStream, WebSocketServer } from "ws";

const [port, webPort, user, password] = process.argv.slice(2);
const forbidden = (topic) => topic.startsWith("forbidden/");
const broker = aedes({
  authenticate: (client, name, secret, done) =>
    user === undefined || (name === user && String(secret) === password)
      ? done(null, true)
      : done(Object.assign(new Error("bad user name or password"), { returnCode: 4 }), false),
  authorizePublish: (client, packet, done) => done(forbidden(packet.topic) ? new Error("forbidden") : null),
  authorizeSubscribe: (client, subscription, done) => done(null, forbidden(subscription.topic) ? null : subscription),
});

const plain = net.createServer(broker.handle);
const web = http.createServer();
new WebSocketServer({ server: web, handleProtocols: () => "mqtt" }).on("connection", (socket, request) =>
  broker.handle(createWebSocketStream(socket), request));
plain.listen(port, "127.0.0.1", () =>
  web.listen(webPort, "127.0.0.1", () => console.log(`listening on ${plain.address().port} ${web.address().port} `)));
