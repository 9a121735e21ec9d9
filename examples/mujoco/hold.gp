# Draws what hold printed, once listening and once deaf:
#   gnuplot -e "listening = 'FILE'; deaf = 'FILE'; picture = 'FILE.svg'" hold.gp
set terminal svg size 900,760 font 'sans,13' background 'white'
set output picture
set multiplot layout 3,1
set lmargin 11
set rmargin 4
set xrange [0:8]
set grid
lines = '< grep friction '
set arrow 1 from 3.5, graph 0 to 3.5, graph 1 nohead dt 3 lc 'gray40'
set arrow 2 from 5.5, graph 0 to 5.5, graph 1 nohead dt 3 lc 'gray40'
set label 1 'friction 0.8' at 2.4, graph 0.9
set label 2 '0.5' at 3.6, graph 0.9
set label 3 '0.35' at 5.6, graph 0.9
set ylabel 'margin that slipd tells'
set yrange [0:1.05]
set key bottom left
plot lines.listening using 1:7 with linespoints pt 7 ps 0.3 lw 2 lc 'dark-green' title 'listening', \
     lines.deaf using 1:7 with linespoints pt 7 ps 0.3 lw 2 lc 'red' title 'deaf'
unset label
set key off
set ylabel 'force of a finger, N'
set yrange [0:10]
plot lines.listening using 1:9 with lines lw 2 lc 'dark-green', lines.deaf using 1:9 with lines lw 2 lc 'red'
set ylabel 'the box fell, mm'
set xlabel 'time, s'
set yrange [-1:20]
plot lines.listening using 1:12 with lines lw 2 lc 'dark-green', lines.deaf using 1:12 with lines lw 2 lc 'red'
