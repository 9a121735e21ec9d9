# docs/pictures/one-grasp.svg: margin, truth and alert of three kinds of sensors over one grasp. Variables: folder, picture, length.
set terminal svg size 900,640 font "sans-serif,12" background "#ffffff"
set output picture
set datafile separator ","
set multiplot layout 3,1 margins 0.08,0.80,0.09,0.95 spacing 0,0.09
set yrange [0:1.05]
set xrange [0:length]
set ytics 0.5
set ylabel "margin"
set style fill solid noborder
level(alert) = alert eq "slip" ? 0.06 : NaN
warned(alert) = alert eq "warn" ? 0.06 : NaN
names = "taxels32 taxels4 force"
titles = "'32 x 32 taxels, friction unknown' '4 x 4 taxels, friction given as 0.45 to 0.8' 'one force, friction given as 0.45 to 0.8'"
do for [i = 1:3] {
  file = folder . "/" . word(names, i) . ".csv"
  set title word(titles, i) offset 0,-0.8
  if (i == 1) { set key outside right center samplen 2 spacing 1.3 } else { set key off }
  if (i == 3) { set xlabel "time, s"; set format x "%g" } else { set format x "" }
  plot file every 4::1 using 1:2 with lines lc rgb "#000000" lw 3 title "truth", \
       "" every 4::1 using 1:3 with lines lw 2 lc rgb "#1f77b4" title "margin (gamma)", \
       "" every 4::1 using 1:4 with lines lc rgb "#2ca02c" lw 1 title "gamma\\_low", \
       "" every 4::1 using 1:(warned(strcol(5))) with impulses lw 4 lc rgb "#e6a100" title "alert warn", \
       "" every 4::1 using 1:(level(strcol(5))) with impulses lw 4 lc rgb "#d62728" title "alert slip"
}
unset multiplot
