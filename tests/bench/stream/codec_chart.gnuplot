# SPDX-License-Identifier: Apache-2.0
# Draws error against bytes for every encoding of codec_bench, in the style of the other charts:
#   gnuplot -e "csv='tests/bench/results/MACHINE/codec.csv'; svg='tests/bench/results/MACHINE/chart/codec.svg'" tests/bench/stream/codec_chart.gnuplot
set terminal svg size 980,560 font 'Helvetica,12' background rgb 'white'
set output svg
set datafile separator ','
set multiplot
set logscale xy
set grid xtics ytics lc rgb '#e4e4e4'
set tics font ',10'
set format x '%g'
set xlabel 'Mbit/s at 90 Hz' offset 0,0.4
set xrange [4:60000]
set key at screen 0.5,0.15 center maxrows 3 Left reverse samplen 2.5 spacing 1.2 width 1 font ',10'
set label 1 'What encodings cost: four torn blocks of 1331 nodes, 200 boxes, a million kernels' at screen 0.02,0.965 font ',14' noenhanced
set label 2 'Quantisation steps of the stream from 229 (left) to 3.6 um. Bytes of the blocks and boxes, or of the kernels. Exact encodings are on the lower edge.' at screen 0.02,0.925 font ',10' tc rgb '#555555' noenhanced
set tmargin at screen 0.86
set bmargin at screen 0.30
pick(name, part, value) = strstrt(name, part) == 1 ? value : NaN
above(value, floor) = value > floor ? value : floor
stream(name, frames) = strstrt(name, 'drivers in steps') == 1 && frames > 100  # excludes the row of sleeping objects
do for [panel = 1:2] {
  set lmargin at screen (panel == 1 ? 0.075 : 0.565)
  set rmargin at screen (panel == 1 ? 0.485 : 0.975)
  set ylabel (panel == 1 ? 'kernel off by, mm (99 of 100 and largest)' : 'kernel turned by, degrees (99 of 100, largest)') offset 1,0
  set yrange [(panel == 1 ? 2e-5 : 1e-5):(panel == 1 ? 1 : 1000)]
  set format y '10^{%T}'
  bar = panel == 1 ? 0.05 : 0.1
  least = panel == 1 ? 2.6e-5 : 1.3e-5
  p99 = panel == 1 ? 10 : 12
  largest = panel == 1 ? 11 : 14
  set arrow 1 from 8, graph 0 to 8, graph 1 nohead dt 3 lw 1.2 lc rgb '#444444'
  if (panel == 2) { unset label 1; unset label 2; unset key }
  plot bar with lines dt 3 lw 1.2 lc rgb '#444444' title 'bounds: 0.05 mm, 0.1 degrees, 8 Mbit/s', \
    csv using (stream(strcol(1), column(3)) ? column(7) : NaN):(above(column(p99), least)) skip 1 with linespoints lc rgb '#0072B2' pt 7 ps 0.6 lw 2.6 title 'drivers, a stream', \
    csv using (stream(strcol(1), column(3)) ? column(7) : NaN):(above(column(largest), least)) skip 1 with linespoints lc rgb '#0072B2' dt 2 pt 6 ps 0.6 lw 1.2 title 'drivers, a stream, maximum', \
    csv using (pick(strcol(1), 'drivers in steps of 57.2', column(3) > 100 ? column(7) : NaN)):(above(column(p99), least)) skip 1 with points pt 3 ps 1.3 lw 2.4 lc rgb '#B00020' title 'default', \
    csv using (pick(strcol(1), 'drivers without', column(7))):(above(column(p99), least)) skip 1 with points pt 8 ps 1 lw 1.6 lc rgb '#009E73' title 'without neighbours', \
    csv using (pick(strcol(1), 'drivers self', column(7))):(above(column(p99), least)) skip 1 with points pt 11 ps 1 lc rgb '#D55E00' title 'drivers, self-contained', \
    csv using (pick(strcol(1), 'drivers raw', column(7))):(above(column(p99), least)) skip 1 with points pt 9 ps 1 lc rgb '#E69F00' title 'drivers, raw floats', \
    csv using (pick(strcol(1), 'kernels quantised', column(7))):(above(column(p99), least)) skip 1 with points pt 13 ps 1.2 lc rgb '#CC79A7' title 'kernels, quantised', \
    csv using (pick(strcol(1), 'kernels exact', column(7))):(above(column(p99), least)) skip 1 with points pt 5 ps 1 lc rgb '#000000' title 'kernels, exact'
}
unset multiplot
