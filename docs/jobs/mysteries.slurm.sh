#!/usr/bin/env bash
# Mysteries made, diagnosed and judged as a job array of SLURM: one task is one shard. From a folder that all nodes share,
#
#     sbatch mysteries.slurm.sh
#     sbatch --dependency=afterany:JOBID --wrap 'sealegs merge judged --json judged.json'
#
# A task that was ended is sent again by the same line: what is done is not done twice. The size of the array is free:
# `sbatch --array=1-4` lets four tasks do sixteen mysteries each. SEEDS, BENCH, LEVEL, DURATION and JOBS change what is done.
#SBATCH --job-name=sealegs
#SBATCH --array=1-64%16
#SBATCH --cpus-per-task=1
#SBATCH --mem=2G
#SBATCH --time=01:00:00
set -euo pipefail

# As many threads as the task has cores; the result is the same for any number.
export RAYON_NUM_THREADS=${SLURM_CPUS_PER_TASK:-1}

sealegs mystery --seed "${SEEDS:-1-64}" --bench "${BENCH:-locked}" --level "${LEVEL:-easy}" --duration "${DURATION:-20}" \
    --judge --jobs "${JOBS:-judged}" --shard "$SLURM_ARRAY_TASK_ID/$SLURM_ARRAY_TASK_COUNT"
