"""Publishes images that are drawn in the memory from which readers on this host read them.

    python3 images.py         # publishes the topic 'image', until Ctrl-C
    python3 images.py --demo  # reads it, too, by asyncio, and ends after 10 images
"""

import asyncio
import sys

import numpy as np

import sft

HEIGHT, WIDTH = 480, 640


async def publish(node):
    publisher = node.publisher("image", "sensor_msgs/Image")
    number = 0
    while True:
        # A number in place of a sequence reserves that many elements. The end of the block publishes the loan.
        with publisher.loan(header="auto", height=HEIGHT, width=WIDTH, encoding="rgb8", step=3 * WIDTH,
                            data=3 * HEIGHT * WIDTH) as image:
            image.data.reshape(HEIGHT, WIDTH, 3)[:, :, 0] = (np.arange(WIDTH) + number) % 256
        number += 1
        await asyncio.sleep(0.05)


async def read(node, count):
    async for image in node.subscriber("image"):
        pixels = image.image()  # height x width x channels, not copied
        print(f"{pixels.shape}: red {pixels[..., 0].mean():.1f}, by {image.info.transport}")
        count -= 1
        if count == 0:
            return


async def main():
    with sft.Node("camera") as node:
        publishing = asyncio.create_task(publish(node))
        if "--demo" in sys.argv:
            await asyncio.sleep(0.1)
            await read(node, 10)
            publishing.cancel()
        else:
            await publishing
    print("It ended well.")


if __name__ == "__main__":
    try:
        asyncio.run(main())
    except KeyboardInterrupt:
        pass
