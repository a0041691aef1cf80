# One command for many robots: the cost per robot from ten to a hundred thousand, sent and confirmed. Robots of ours answer both
# sides; whoever commands is what differs. The names come from standard input: a pattern would have to find them first.

# confirmed COUNT RUNS FIGURE OPTION…
confirmed() {
  compare "$2" "$3" \
    fleetpub "<$(names "$1")" $fleetpub pause - --wait --vda 3.0 --no-check --quiet "${@:4}" -- \
    'raw socket' build/release/tests/bench/raw_commander "$broker_port" "$1"
}
heading 'Commanded and confirmed FINISHED by virtual robots, beside a raw socket without ledger or validation' fleetpub 'raw socket'
with_robots 1 confirmed 1 100 'one robot, confirmed' --no-check
with_robots 1 confirmed 1 100 'one robot, confirmed, checked'
with_robots 10000 confirmed 10000 5 '10000 robots, confirmed, checked'
for count in 10 100 1000 10000 30000 100000; do
  case $count in 10 | 100) times=50 ;; 1000) times=20 ;; 100000) times=3 ;; *) times=7 ;; esac
  with_robots $count confirmed $count $times "$count robots, confirmed" --no-check
done
echo
heading 'Built, validated, stamped, recorded and sent, beside the raw sending of packets that are made already' fleetpub 'raw socket'
for count in 10 100 1000 10000 30000 100000; do
  case $count in 10 | 100) times=50 ;; 1000) times=20 ;; 100000) times=3 ;; *) times=7 ;; esac
  for qos in 0 1; do
    compare $times "$count robots, sent at QoS $qos" \
      fleetpub "<$(names $count)" $fleetpub pause - --vda 3.0 --no-check --quiet -q $qos -- \
      'raw socket' build/release/tests/bench/raw_commander "$broker_port" $count $qos
  done
done
