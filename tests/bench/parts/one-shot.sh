# One message, one process: what each program takes from start to end.
heading "One shot, $runs pairs: build, durable stamp, record, validate, publish, record the outcome" fleetpub mosquitto_pub
for linked in static release; do
  program=build/release/src/fleetpub
  [ $linked = release ] || program+=-static
  for qos in 0 1; do
    compare "$runs" "one shot, $linked, QoS $qos" \
      fleetpub $program pause KIT/0001 --vda 3.0 --no-check --quiet -q $qos -- \
      mosquitto_pub mosquitto_pub -h 127.0.0.1 -p "$broker_port" -t "$topic" -m "$message" -q $qos
  done
done
mosquitto_pub -h 127.0.0.1 -p "$broker_port" -r -t vda5050/v3/KIT/0001/connection \
  -m '{"headerId":1,"timestamp":"2026-01-02T03:04:05.678Z","version":"3.0.0","manufacturer":"KIT","serialNumber":"0001","connectionState":"ONLINE"}'
compare "$runs" 'one shot, static, QoS 0, the robot looked up and checked' \
  fleetpub build/release/src/fleetpub-static pause KIT/0001 --quiet -- \
  mosquitto_pub mosquitto_pub -h 127.0.0.1 -p "$broker_port" -t "$topic" -m "$message"
memory=$(mktemp -d -p /dev/shm)
folders+=("$memory")
compare "$runs" 'one shot, static, QoS 0, ledger in memory' \
  fleetpub build/release/src/fleetpub-static pause KIT/0001 --vda 3.0 --no-check --quiet --ledger "$memory/ledger.db" -- \
  mosquitto_pub mosquitto_pub -h 127.0.0.1 -p "$broker_port" -t "$topic" -m "$message"
echo
heading "The same beside what else people use, $runs turns at QoS 0"
compare "$runs" 'one shot, distribution' \
  'fleetpub (static)' build/release/src/fleetpub-static pause KIT/0001 --vda 3.0 --no-check --quiet -- \
  'fleetpub (release)' build/release/src/fleetpub pause KIT/0001 --vda 3.0 --no-check --quiet -- \
  'mosquitto_pub (ready text)' mosquitto_pub -h 127.0.0.1 -p "$broker_port" -t "$topic" -m "$message" -- \
  'shell script' tests/bench/one_shot.sh "$broker_port" KIT 0001 "$home/header-id" -- \
  'MQTT.js (ready text)' node tests/peers/node_modules/mqtt/build/bin/mqtt.js publish -h 127.0.0.1 -p "$broker_port" -t "$topic" -m "$message"
