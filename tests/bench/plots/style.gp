# What all plots share. The colours are Okabe and Ito's, which colour-blind people tell apart, without those too pale on white.
set datafile separator ","
set encoding utf8
set terminal svg size 860,460 dynamic noenhanced font "sans-serif,14" background "white" linewidth 1.2
set border 3 linecolor "#888888" linewidth 0.8
set tics nomirror textcolor "#222222"
set grid linecolor "#dddddd" linetype 1 linewidth 0.6
set linetype 1 linecolor "#0072B2" linewidth 2 pointtype 7
set linetype 2 linecolor "#D55E00" linewidth 2 pointtype 5
set linetype 3 linecolor "#009E73" linewidth 2 pointtype 9
set linetype 4 linecolor "#CC79A7" linewidth 2 pointtype 13
set linetype 5 linecolor "#000000" linewidth 2 pointtype 11
set linetype 6 linecolor "#56B4E9" linewidth 2 pointtype 7
set linetype 7 linecolor "#E69F00" linewidth 2 pointtype 5
set linetype 8 linecolor "#777777" linewidth 2 pointtype 9
