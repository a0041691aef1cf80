# A broker 30 ms away: each byte takes 15 ms.
helper build/release/tests/bench/delay "$broker_port" 15
await_helper test -s "$said"
distant=$(cat "$said")
heading 'At a round trip of 30 ms' fleetpub peer
for qos in 0 1; do
  compare 30 "one shot at 30 ms, QoS $qos" \
    fleetpub $fleetpub pause KIT/0001 --vda 3.0 --no-check --quiet -q $qos -b "$distant" -- \
    mosquitto_pub mosquitto_pub -h 127.0.0.1 -p "${distant##*:}" -t "$topic" -m "$message" -q $qos
done
compare 5 '10000 robots at 30 ms, sent at QoS 1' \
  fleetpub "<$(names 10000)" $fleetpub pause - --vda 3.0 --no-check --quiet -q 1 -b "$distant" -- \
  'raw socket' build/release/tests/bench/raw_commander "${distant##*:}" 10000 1
end_helper
