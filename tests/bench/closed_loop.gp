# The course of one errand, as closed-loop wrote it: gnuplot -e "trace = 'FILE.csv'; picture = 'FILE.svg'" closed_loop.gp
set terminal svg size 860,560 dynamic font 'sans-serif,13' background rgb 'white'
set output picture
set datafile separator ','
set multiplot layout 2,1
set key outside right width -4
set grid lc rgb '#dddddd'
set lmargin 8
set rmargin 30
set ylabel 'normal force (N)'
plot trace using 1:2 with lines lw 2 lc rgb '#0a6ebd' title 'gripper that listens', \
     trace using 1:3 with lines lw 2 lc rgb '#c0504d' title 'deaf gripper', \
     trace using 1:4 with lines lw 1 lc rgb '#555555' dt 2 title 'least possible'
set ylabel 'safety margin'
set xlabel 'time (s)'
set yrange [0:1]
plot trace using 1:5 with lines lw 2 lc rgb '#0a6ebd' title 'gripper that listens', \
     trace using 1:6 with lines lw 2 lc rgb '#c0504d' title 'deaf gripper', \
     trace using 1:7 with lines lw 1 lc rgb '#4f9d3a' title 'as heard on CAN'
unset multiplot
