"""What a notebook would do, cell by cell: look at the topics, take a sample, plot a cloud from above.

    python3 notebook.py         # needs a program that publishes 'points', and matplotlib for the picture
    python3 notebook.py --demo  # publishes it itself
"""

# %% Join, and see what there is.
import sys
import threading

import numpy as np

import sft
from cloud_to_numpy import scan

node = sft.Node("notebook")
if "--demo" in sys.argv:
    threading.Thread(target=scan, args=(node,), daemon=True).start()
cloud_type = node.find_type("points", timeout=30)
for topic in node.topics():
    print(f"{topic['topic']:20} {topic['type']:30} published by {', '.join(topic['publishers'])}")

# %% Take every 16th point of one cloud. A cell that shows a sample keeps it; copy() would hold nothing.
subscriber = node.subscriber("points", cloud_type, "height, width, data{x,y,z}[::16]")
cloud = subscriber.wait_for_sample(timeout=30)
print(repr(cloud))
points = cloud.points("x", "y", "z")
print(points.shape, points.dtype.names, f"mean height {np.mean(points['z']):.2f} m")

# %% Plot it from above.
try:
    import matplotlib
    matplotlib.use("Agg")
    import matplotlib.pyplot as plt
except ImportError:
    print("There is no matplotlib, so there is no picture: apt install python3-matplotlib")
else:
    plt.scatter(points["x"], points["y"], c=points["z"], s=1)
    plt.gca().set_aspect("equal")
    plt.xlabel("x [m]")
    plt.ylabel("y [m]")
    plt.savefig("/dev/null" if "--demo" in sys.argv else "points.png", format="png")

# %%
node.close()
print("It ended well.")
