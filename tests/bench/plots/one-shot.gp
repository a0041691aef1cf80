load "tests/bench/plots/style.gp"
set title "One message at QoS 0: how many of the calls had ended by then"
set xlabel "milliseconds from start to end of the process"
set ylabel "% of the calls"
set logscale x
set xtics (0.5, 1, 2, 3, 5, 10, 20, 50, 100, 200, 500, 1000, 2000)
set yrange [0:100]
set key outside right center vertical Left reverse
plot for [column=2:6] table using column:1 with lines linetype column-1 title columnheader(column)
