# Draws the pictures of ./run bench paper --plots DIR from the data in the current directory.
set datafile separator ","
set terminal svg size 1200,480 font "sans,11" background "#ffffff"
set style data histogram
set style histogram errorbars gap 1.5 lw 1
set style fill solid 0.8 border -1
set boxwidth 0.9
set key top left horizontal
set grid ytics
set xtics rotate by -60 nomirror
set yrange [0:*]

columns(file) = sprintf("for [i = 2:8:2] '%s' using i:(column(i + 1)):xtic(1) title columnheader(i)", file)

set ylabel "kbit/s at the receivers, at 10 Hz"
do for [receivers in "1 3"] {
  set title sprintf("Parametric study, %s receiver(s): bandwidth; bars show one standard deviation", receivers)
  set output sprintf("bandwidth_%s.svg", receivers)
  file = sprintf("bandwidth_%s.csv", receivers)
  stats file every ::1 using 2 nooutput
  if (STATS_records > 0) { eval "plot ".columns(file) }
}

set ylabel "us from publish() to the callback"
do for [receivers in "1 3"] {
  set title sprintf("Parametric study, %s receiver(s): latency; bars show one standard deviation", receivers)
  set output sprintf("latency_%s.svg", receivers)
  file = sprintf("latency_%s.csv", receivers)
  stats file every ::1 using 2 nooutput
  if (STATS_records > 0) { eval "plot ".columns(file) }
}

set xtics rotate by -20
set logscale y
set yrange [*:*]
set title "Nav2 and PointCloud2: bandwidth; bars show one standard deviation"
set ylabel "kbit/s at the receivers, at 10 Hz"
set output "cases_bandwidth.svg"
eval "plot ".columns("cases_bandwidth.csv")

set title "Nav2 and PointCloud2: latency; bars show one standard deviation"
set ylabel "us from publish() to the callback"
set output "cases_latency.svg"
eval "plot ".columns("cases_latency.csv")

unset logscale y
set xtics norotate
set style data points
set yrange [0:*]
set title "Response: 7 fields of 512 bytes, of which the program reads 4"
set xlabel "ms since the first message"
set ylabel "bytes of fields in the message"
set output "trace.svg"
plot "trace.csv" every ::1 using 1:2 with impulses lw 3 title "message arrives", \
  "trace_events.csv" every ::1 using 2:3:1 with labels left point pt 7 offset 1,0 notitle
set output
