load "tests/bench/plots/style.gp"
set terminal svg size 900,120+62*bars dynamic noenhanced font "sans-serif,14" background "white" linewidth 1.2
set title "What a command spends, stage by stage"
set xlabel "% of the instructions, or of the time in system calls"
set xrange [0:100]
set yrange [-bars - 0.5:-0.4]
unset ytics
set border 1
set grid noytics
set key outside right center vertical Left reverse samplen 1.5
set style fill solid 1 border linecolor "white"
# Paul Tol's light scheme and some more: black text can be read on all of them.
colours = "#77AADD #99DDFF #44BB99 #BBCC33 #EEDD88 #EE8866 #FFAABB #CCBBEE #AAAA00 #C8A27A #88CCBB #D9B3A0 #B0B8E0 #DDDDDD"
called(i) = system(sprintf("echo '%s' | tr _ ' '", word(names, i)))
plot for [i=1:words(names)] \
    table using ($3 == i ? $6 : NaN):(-$2):6:7:(-$2 - 0.25):(-$2 + 0.25) skip 1 with boxxyerror linecolor rgb word(colours, i) title called(i), \
  table using (($6 + $7) / 2):($7 - $6 > 8 ? -$2 : NaN):4 skip 1 with labels font "sans-serif,11" notitle, \
  table using (0):($3 == 1 ? -$2 + 0.38 : NaN):1 skip 1 with labels left notitle
