load "tests/bench/plots/style.gp"
set title "One command to many robots: time per robot"
set xlabel "robots"
set ylabel "µs per robot (median)"
set logscale xy
set xtics ("10" 10, "100" 100, "1,000" 1000, "10,000" 10000, "100,000" 100000)
set xrange [8:125000]
set yrange [1:]
set key outside right center vertical Left reverse samplen 2.5
plot for [i=0:5] table using 1:i+2 with linespoints \
  linetype i/2+1 dashtype i%2*2+1 pointsize 0.7 title columnheader(i+2)
