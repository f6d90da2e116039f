# catkin's setup.bash reads this: what Debian lacks (CasADi, PIQP, pyrealsense2) and the Debian package seater brings.
PYTHONPATH="$CATKIN_ENV_HOOK_WORKSPACE/pypi${PYTHONPATH:+:$PYTHONPATH}"
# The small matrices of the solver only lose time to threads.
OPENBLAS_NUM_THREADS=1 OMP_NUM_THREADS=1
export PYTHONPATH OPENBLAS_NUM_THREADS OMP_NUM_THREADS
