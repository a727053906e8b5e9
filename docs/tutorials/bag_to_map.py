# %% [markdown]
# # From a bag to a map
#
# A ROS bag with laser scans and wheel odometry becomes a map, in five commands. No true pose is
# used for it, and nobody says where the laser's rays point or what is wrong with the wheels.
# Reading bags and writing tables takes `pip install 'motorspace[ros,table]'`. All of this page is
# done in four minutes.

# %%
import math
import shlex
from pathlib import Path

import jax
import matplotlib.pyplot as plt
import numpy as np
from rosbags.rosbag2 import Writer
from rosbags.typesys import Stores, get_typestore

import motorspace as ms
from motorspace import se2
from motorspace.cli.main import main
from motorspace.mapping.mounting import Mounting
from motorspace.mapping.occupancy import occupancy
from motorspace.worlds.maps.map_server import read_description

SCANS = 2000
EPOCHS = 100

# %% [markdown]
# ## A drive through rooms
#
# You have a bag. We have none, so we simulate a robot: it drives about in random rooms, slows down
# and speeds up, and turns away from walls. Its wheels are worse than they say: odometry reads every
# turn 6 % too narrow and every way 3 % too long, with noise of 5 %.

# %%
scenario = ms.Scenario(
    "rooms:2003", ms.ForwardAgent(max_rotation=0.15 * math.pi), ms.RangeFan(num_rays=121)
)
step = jax.jit(lambda pose, motor: scenario.step(pose, motor)[0])
sense = jax.jit(lambda pose: scenario.sense(pose))
random = np.random.default_rng(0)
pose, turn, side, ranges, truth = scenario.start(key=jax.random.key(1)), 0.0, 1, [], []
for _ in range(SCANS):
    ranges.append(np.asarray(sense(pose)))
    truth.append([float(part) for part in (pose.x, pose.y, pose.heading)])
    turn = np.clip(0.8 * turn + random.normal(scale=0.1), -0.4, 0.4)
    ahead = np.clip(random.normal(0.35, 0.1), 0, 1)
    if ranges[-1][40:81].min() < 1.5:  # a wall ahead: towards the side with more room
        if turn * side <= 0 or abs(turn) < 0.4:
            side = 1 if ranges[-1][61:].mean() > ranges[-1][:60].mean() else -1
        turn, ahead = 0.4 * side, 0.1
    pose = step(pose, np.float32([turn, ahead]))
truth = np.array(truth).T

moved = np.asarray(se2.relative(truth[:, :-1], truth[:, 1:]))
moved = moved * np.array([[1.03], [1.03], [0.94]]) * (1 + 0.05 * random.normal(size=moved.shape))
odometry = np.zeros((3, SCANS))
for index in range(1, SCANS):
    odometry[:, index] = se2.compose(odometry[:, index - 1], moved[:, index - 1])

# %% [markdown]
# ## The bag
#
# `/scan` holds a `LaserScan` twice a second, `/odom` an `Odometry` beside each. `/truth` holds
# what no robot has: true poses, which are used for scores alone.

# %%
store = get_typestore(Stores.ROS2_HUMBLE)
half = math.pi / 2


def make(kind, **fields):
    return store.types[kind](**fields)


def header(time, frame):
    stamp = make("builtin_interfaces/msg/Time", sec=int(time), nanosec=int(time % 1 * 1e9))
    return make("std_msgs/msg/Header", stamp=stamp, frame_id=frame)


def laser_scan(time, readings):
    return make(
        "sensor_msgs/msg/LaserScan",
        header=header(time, "laser"),
        angle_min=-half,
        angle_max=half,
        angle_increment=math.pi / (len(readings) - 1),
        time_increment=0.0,
        scan_time=0.5,
        range_min=0.05,
        range_max=10.0,
        ranges=readings.astype(np.float32),
        intensities=np.zeros(0, np.float32),
    )


def placed(x, y, angle):
    turned = {"x": 0.0, "y": 0.0, "z": math.sin(angle / 2), "w": math.cos(angle / 2)}
    return make(
        "geometry_msgs/msg/Pose",
        position=make("geometry_msgs/msg/Point", x=x, y=y, z=0.0),
        orientation=make("geometry_msgs/msg/Quaternion", **turned),
    )


def true_pose(time, place):
    return make("geometry_msgs/msg/PoseStamped", header=header(time, "map"), pose=placed(*place))


def wheel_odometry(time, place):
    rest = make("geometry_msgs/msg/Vector3", x=0.0, y=0.0, z=0.0)
    still = make("geometry_msgs/msg/Twist", linear=rest, angular=rest)
    unknown = np.zeros(36)
    return make(
        "nav_msgs/msg/Odometry",
        header=header(time, "odom"),
        child_frame_id="base_link",
        pose=make("geometry_msgs/msg/PoseWithCovariance", pose=placed(*place), covariance=unknown),
        twist=make("geometry_msgs/msg/TwistWithCovariance", twist=still, covariance=unknown),
    )


topics = {
    "/scan": ("sensor_msgs/msg/LaserScan", laser_scan, ranges),
    "/odom": ("nav_msgs/msg/Odometry", wheel_odometry, odometry.T.tolist()),
    "/truth": ("geometry_msgs/msg/PoseStamped", true_pose, truth.T.tolist()),
}
with Writer("hall", version=9) as writer:
    for topic, (kind, message, values) in topics.items():
        connection = writer.add_connection(topic, kind, typestore=store)
        for index, value in enumerate(values):
            time = 1000 + index / 2
            content = store.serialize_cdr(message(time, value), kind)
            writer.write(connection, round(time * 1e9), content)

# %% [markdown]
# ## Look before you learn
#
# From here on everything can be typed into a terminal; `command` does the same here. `inspect` says
# what the bag holds, and draws the path by odometry beside the true one, where that is known.


# %%
def command(line):
    main(shlex.split(line)[1:])


command("motorspace inspect hall --max-range 10 --truth-topic /truth --out seen")


pixels = plt.imread("seen/path.png")
figure = plt.figure(figsize=(6, 6 * pixels.shape[0] / pixels.shape[1]))
figure.add_axes((0, 0, 1, 1)).imshow(pixels)
plt.axis("off")

# %% [markdown]
# Both begin at the dot. The wheels' path soon leaves the rooms.
#
# ## Learn what commands do
#
# `import` writes what was read as a table: 30 of the rays suffice for learning. The preset `log`
# learns from it by prediction alone: what will be read after six commands.

# %%
command("motorspace import hall --max-range 10 --num-rays 30 --out hall.parquet")
command(f"motorspace train --data hall.parquet --preset log --epochs {EPOCHS} --out run")
command("motorspace evaluate run")

# %% [markdown]
# Prediction leaves a quarter of the error of "nothing changes" (`persistence`). The probes compare
# codes with the wheels' own odometry, since the table knows no better.
#
# ## Odometry of codes
#
# The codes of commands are chained to a path. 300 pairs of neighbouring scans have laid them into
# the frame of the rays. Matches of all neighbours say what is still wrong on average; `corrected`
# is without it. `path.ate` is the root mean square distance from the true path in metres, and
# *standing still* is what any odometry has to beat.

# %%
log = "hall --max-range 10 --num-rays 121 --truth-topic /truth"
command(f"motorspace odometry run {log} --out path.csv --save-calibration robot.json")

# %% [markdown]
# Off by about a metre on a way of 670 metres, without a loop. How wide a turn is has come from the
# scans, not from the wheels and not from prediction. `path.csv` holds a standard deviation of
# every step, and `robot.json` what was learned of the robot: `--calibration robot.json` uses it
# for drives where there are no walls to match.
#
# ## The map
#
# Where the robot comes back to a place, its scans are recognised as those of before, and a pose
# graph puts all of it together.

# %%
command(f"motorspace map run {log} --out map")

# %% [markdown]
# With loops the path is off by a centimetre. `covariance.68` and `covariance.95` say how many
# errors lie where 68 and 95 of 100 should: more do, so the uncertainty is stated somewhat too
# large here.
#
# The folder holds a page (`map/map.html`), the path as CSV, and the map as ROS's `map_server` reads
# it. Left, the same scans at the poses of the wheels. Right, what was written.

# %%
rays = Mounting(scenario.sensor.angles, np.zeros(2), 10.0)
raw = occupancy(odometry, np.array(ranges), rays, cell=0.1)
described = read_description(Path("map/map.yaml").read_text(), where="map/map.yaml")
pixels, cell, (x, y, _) = plt.imread("map/map.pgm"), described.resolution, described.origin
extent = (x, x + cell * pixels.shape[1], y, y + cell * pixels.shape[0])
walked = np.genfromtxt("map/path.csv", delimiter=",", names=True)

figure, (left, right) = plt.subplots(1, 2, figsize=(9, 4.5), layout="constrained")
left.imshow(np.where(raw.occupied, 0, np.where(raw.seen, 254, 205)).T[::-1], cmap="gray", vmin=0)
right.imshow(pixels, cmap="gray", vmin=0, vmax=255, extent=extent)
right.plot(walked["x"], walked["y"], lw=0.7)
for axes, title in ((left, "the scans at the wheels' poses"), (right, "map.pgm and path.csv")):
    axes.set(title=title, xticks=[], yticks=[])

# %% [markdown]
# Grey was never seen. White rays into it are doorways that the robot looked through; there are
# rooms that it has not been in. This world is kind to a mapper: its walls are straight, its scans
# exact. [Recorded robots](../results/robots.md) are harder; [a map without odometry](../maps.md)
# says how it works and when it fails.
#
# In a terminal:
#
# ```
# motorspace inspect hall --max-range 10 --out seen
# motorspace import hall --max-range 10 --num-rays 30 --out hall.parquet
# motorspace train --data hall.parquet --preset log --out run
# motorspace odometry run hall --max-range 10 --num-rays 121 --save-calibration robot.json
# motorspace map run hall --max-range 10 --num-rays 121 --out map
# ```
