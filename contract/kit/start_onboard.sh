#!/bin/sh
# Starts the robot `amr-1` of this project with simulated devices, for `kit robot --start`:
#   start_onboard.sh PROGRAMS CONFIG SITE ENDPOINT PREFIX FOLDER
# PROGRAMS is the folder with `rig` and `onboard`. Each start is that of a robot which was carried to its start.
set -eu
programs=$1 config=$2 site=$3 endpoint=$4 prefix=$5 folder=$6
# On an address of its own: nobody else takes the port meanwhile.
host=127.$(($$ / 256 % 256)).$(($$ % 256)).1
port=$(python3 -c 'import socket, sys; s = socket.socket(socket.AF_INET, socket.SOCK_DGRAM); s.bind((sys.argv[1], 0)); print(s.getsockname()[1])' $host)
runtime=$(mktemp -d "$folder/XXXXXX")
"$programs/rig" devices --robot "$config/robots/amr-1.toml" --site "$config/sites/$site.toml" \
    --ethercat "udp:$host:$port" --lidar "$runtime/lidar" &
until [ -e "$runtime/lidar" ]; do sleep 0.1; done
# Its operator: a computer that is busy with other things too stops the robot now and then, as one with a bad bus or a late thread.
while sleep 3; do "$programs/onboard" ctl reset --runtime "$runtime" >"$runtime/operator" 2>&1 || true; done &
exec "$programs/onboard" run --robot "$config/robots/amr-1.toml" --site "$config/sites/$site.toml" --runtime "$runtime" --state "$runtime" \
    --set "ethercat.udp=\"$host:$port\"" --set "lidar.device=\"$runtime/lidar\"" \
    --set "fleet.connect=[\"$endpoint\"]" --set "fleet.key_prefix=\"$prefix\""
