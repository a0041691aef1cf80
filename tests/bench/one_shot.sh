#!/bin/sh
# What people write who have no fleetpub: builds startPause, counts its header id in a file, and publishes it. Nothing is
# validated, recorded, or safe against a second one at the same time.
#   one_shot.sh PORT MANUFACTURER SERIAL COUNTER
id=$(cat "$4" 2>/dev/null || echo 0)
echo $((id + 1)) >"$4"
message=$(jq -cn --argjson id "$id" --arg time "$(date -u +%FT%T.%3NZ)" --arg maker "$2" --arg serial "$3" --arg action "$(uuidgen)" \
  '{headerId: $id, timestamp: $time, version: "3.0.0", manufacturer: $maker, serialNumber: $serial,
    actions: [{actionType: "startPause", actionId: $action, blockingType: "NONE"}]}')
mosquitto_pub -h 127.0.0.1 -p "$1" -t "vda5050/v3/$2/$3/instantActions" -m "$message"
