# A broker that speaks TLS; its certificate is verified.
openssl req -x509 -newkey ec -pkeyopt ec_paramgen_curve:P-256 -nodes -days 2 -subj /CN=localhost \
  -addext subjectAltName=DNS:localhost -keyout "$home/broker.key" -out "$home/broker.pem" 2>/dev/null
tls_port=$((broker_port + 1))
printf 'user %s\nlistener %s 127.0.0.1\nallow_anonymous true\ncertfile %s\nkeyfile %s\n' "$(id -un)" "$tls_port" \
  "$home/broker.pem" "$home/broker.key" >"$home/tls.conf"
helper env PATH="$PATH:/usr/sbin" mosquitto -c "$home/tls.conf"
await_helper $fleetpub ping -b "mqtts://localhost:$tls_port" --cafile "$home/broker.pem"
heading 'One shot over TLS, the broker verified' fleetpub mosquitto_pub
for qos in 0 1; do
  compare 100 "one shot over TLS, QoS $qos" \
    fleetpub $fleetpub pause KIT/0001 --vda 3.0 --no-check --quiet -q $qos -b "mqtts://localhost:$tls_port" --cafile "$home/broker.pem" -- \
    mosquitto_pub mosquitto_pub -h localhost -p "$tls_port" --cafile "$home/broker.pem" -t "$topic" -m "$message" -q $qos
done
end_helper
