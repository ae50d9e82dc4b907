#!/bin/sh
# The job array of docs/farm.md on a Slurm of its own: 24 frames, two tasks at once, of which one is
# killed in the middle, are the same files as one process's.
#   slurm.sh PROGRAM SAMPLES WORK DOCS_FARM_MD
# Exit code 77, and a reason, where there is no Slurm (Debian: slurmctld, slurmd, slurm-client).
set -eu
program=$1 samples=$2 work=$3
for tool in slurmctld slurmd sbatch squeue scancel scontrol; do
    PATH=$PATH:/usr/sbin command -v "$tool" >/dev/null || {
        echo "skipped: no $tool here (Debian: slurmctld, slurmd, slurm-client)"
        exit 77
    }
done
PATH=$PATH:/usr/sbin
rm -rf "$work"
mkdir -p "$work/state" "$work/spool" "$work/alone" "$work/array"
host=$(hostname -s)
port=$((20000 + $$ % 20000))
export SLURM_CONF="$work/slurm.conf" SOURCE_DATE_EPOCH=0
cat >"$SLURM_CONF" <<END
ClusterName=fumarole
SlurmctldHost=$host(127.0.0.1)
SlurmctldPort=$port
SlurmdPort=$((port + 1))
SlurmUser=$(id -un)
SlurmdUser=$(id -un)
AuthType=auth/none
CredType=cred/none
MpiDefault=none
ProctrackType=proctrack/pgid
TaskPlugin=task/none
SelectType=select/cons_tres
SelectTypeParameters=CR_Core
ReturnToService=2
StateSaveLocation=$work/state
SlurmdSpoolDir=$work/spool
SlurmctldPidFile=$work/slurmctld.pid
SlurmdPidFile=$work/slurmd.pid
SlurmctldLogFile=$work/slurmctld.log
SlurmdLogFile=$work/slurmd.log
NodeName=$host NodeAddr=127.0.0.1 CPUs=2 State=UNKNOWN
PartitionName=all Nodes=$host Default=YES State=UP
END
slurmctld -D -f "$SLURM_CONF" >/dev/null 2>&1 &
controller=$!
slurmd -D -f "$SLURM_CONF" -N "$host" >/dev/null 2>&1 &
node=$!
stop() {
    kill "$node" "$controller" 2>/dev/null || true
    wait "$node" "$controller" 2>/dev/null || true
}
trap stop EXIT
fail() {
    echo "$*"
    tail -n 20 "$work/slurmctld.log" "$work/slurmd.log" "$work"/array/slurm-*.out 2>/dev/null
    exit 1
}
wait_for() { # SECONDS COMMAND
    left=$(($1 * 5))
    shift
    until "$@"; do
        left=$((left - 1))
        [ "$left" -gt 0 ] || return 1
        sleep 0.2
    done
}
is_up() { [ "$(sinfo -h -o %T 2>/dev/null)" = idle ]; }
wait_for 60 is_up || fail "Slurm does not come up"

render="$program render $samples/smoke_seq.json --frames 1..8 --resume --size 32x18 --aa 2"

is_over() { [ -z "$(squeue -h 2>/dev/null)" ]; }
sed -n '/^#!.bin.sh/,/^exec/p' "$4" | grep -v '^exec' | sed 's/--array=.*/--array=1-2/; s/--cpus-per-task=.*/--cpus-per-task=1/' >"$work/smoke.sh"
cat >>"$work/smoke.sh" <<END
for take in 1 2 3; do
    $render -o "smoke_\${take}_####.exr" || exit
done
END
# A picture's header has the command line: it is the same for both.
(
    cd "$work/alone"
    for take in 1 2 3; do
        $render -o "smoke_${take}_####.exr" >/dev/null
    done
)
job=$(cd "$work" && sbatch --parsable --chdir="$work/array" smoke.sh) || fail "sbatch refuses the job of docs/farm.md"
begun() { [ "$(ls "$work/array" | grep -c 'exr$')" -ge 4 ]; }
wait_for 120 begun || fail "no frame is drawn"
scancel --signal=KILL --full "${job}_1"
wait_for 300 is_over || fail "the job does not end"
[ "$(ls "$work/array" | grep -c 'exr$')" = 24 ] || fail "not 24 frames: $(ls "$work/array")"
for frame in "$work"/alone/*.exr; do
    cmp "$frame" "$work/array/$(basename "$frame")" || fail "another picture"
done
[ -z "$(ls "$work/array" | grep 'lock$')" ] || fail "a lock is left: $(ls "$work/array")"
grep -h -e CANCELLED -e Killed "$work"/array/slurm-*.out >/dev/null || fail "no task was killed"
echo "24 frames of two tasks, one killed, are those of one process"
