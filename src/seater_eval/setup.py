from catkin_pkg.python_setup import generate_distutils_setup
from setuptools import setup

setup(
    **generate_distutils_setup(
        packages=["seater_eval", "seater_eval.baselines", "seater_eval.perception", "seater_eval.ros"],
        package_dir={"": "src"},
    )
)
