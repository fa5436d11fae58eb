"""Shows two numbers of each odometry message. The covariances, which are most of it, are not sent.

    python3 dashboard.py         # shows the topic 'odometry' of other programs, until Ctrl-C
    python3 dashboard.py --demo  # publishes it, too, and ends after 20 samples
"""

import sys
import threading
import time

import sft


def drive(node):
    """Publishes an odometry until the node closes."""
    publisher = node.publisher("odometry", "nav_msgs/Odometry")
    x = 0.0
    while not node.is_interrupted:
        publisher.publish(header="auto", pose={"pose": {"position": {"x": x}}}, twist={"twist": {"linear": {"x": 1.5}}})
        x += 0.015
        time.sleep(0.01)


def main():
    demo = "--demo" in sys.argv
    with sft.Node("dashboard") as node:
        if demo:
            threading.Thread(target=drive, args=(node,), daemon=True).start()
        # It names no fields: SFT notes which ones the loop reads, and soon only these are sent.
        odometry = node.subscriber("odometry")
        for i, sample in enumerate(odometry):
            print(f"at {sample.pose.pose.position.x:.2f} m, {sample.twist.twist.linear.x:.1f} m/s")
            if demo and i == 20:
                break
        print("asked for:", odometry.requested)
    print("It ended well.")


if __name__ == "__main__":
    try:
        main()
    except KeyboardInterrupt:
        pass
