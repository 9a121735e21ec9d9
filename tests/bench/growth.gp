# How times grow: gnuplot -e "data = 'FILE.dat'; picture = 'FILE.svg'; which = 'taxels|points|sensors|clients'" growth.gp
set terminal svg size 720,420 dynamic font 'sans-serif,13' background rgb 'white'
set output picture
set grid lc rgb '#dddddd'
set key left top
set style data linespoints
blue = '#0a6ebd'; red = '#c0504d'; green = '#4f9d3a'; grey = '#555555'
if (which eq 'taxels') {
  set logscale xy; set xlabel 'taxels'; set ylabel 'time of a frame, p50 (us)'
  plot data using 1:2 lw 2 lc rgb blue title 'moments', '' using 1:3 lw 2 lc rgb red title 'svd-knn', \
       '' using 1:4 lw 2 lc rgb green title 'registered', '' using 1:5 lw 2 lc rgb grey title 'fit'
}
if (which eq 'points') {
  set logscale x; set yrange [0:*]; set xlabel 'points of the model'; set ylabel 'time of a frame, p50 (us)'
  plot data using 1:2 lw 2 lc rgb red title 'svd-knn, 16 x 16'
}
if (which eq 'sensors') {
  set yrange [0:*]; set y2range [0:*]; set xlabel 'sensors of 16 x 16 at 1 kHz'; set ylabel 'CPU (% of a core)'
  set y2label 'sample to snapshot (us)'; set ytics nomirror; set y2tics
  plot data using 1:2 lw 2 lc rgb blue title 'CPU', '' using 1:3 axes x1y2 lw 2 lc rgb green title 'latency p50', \
       '' using 1:4 axes x1y2 lw 2 lc rgb red title 'latency p99'
}
if (which eq 'clients') {
  set logscale x; set yrange [0:*]; set xlabel 'clients'; set ylabel 'queries a second'
  plot data using 1:2 lw 2 lc rgb blue title 'slipd gamma', '' using 1:3 lw 2 lc rgb red title 'Redis GET'
}
