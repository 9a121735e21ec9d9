# A guest whose test never ends.
echo "about to hang"
sleep infinity
