# A guest whose kernel panics.
echo "about to panic"
echo c >/proc/sysrq-trigger
sleep infinity
