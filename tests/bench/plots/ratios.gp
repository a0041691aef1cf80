load "tests/bench/plots/style.gp"
set terminal svg size 860,120+24*rows dynamic noenhanced font "sans-serif,14" background "white" linewidth 1.2
set label "fleetpub's time as a multiple of its peer's (median, quartiles)" at screen 0.5, screen 0.96 center
set tmargin 3
set logscale x
set xrange [0.1:25]
set xtics (0.1, 0.2, 0.5, 1, 2, 5, 10)
set yrange [-rows:1]
set border 1
set arrow from 1, graph 0 to 1, graph 1 nohead linecolor "#000000" linewidth 1.2
unset key
plot table using 2:(-$0):3:4:ytic(1) skip 1 with xerrorbars linetype 1 pointsize 0.8 linewidth 1.5, \
  table using (22):(-$0):(sprintf("%.2f", $2)) skip 1 with labels right font "sans-serif,12" textcolor "#0072B2"
