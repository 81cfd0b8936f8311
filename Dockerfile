# cutwise in a container, run by a user that is not root. Kernels are compiled at the first run; to keep them:
#   -v cutwise-kernels:/home/cutwise/.cache
#   docker build -t cutwise .
#   docker run --rm -v "$PWD":/work cutwise run my_edge.yaml
# With STEP parts: docker build --build-arg EXTRAS=[cad] -t cutwise .
# cutwise view listens inside of the container alone; read the report that run writes instead.
FROM python:3.12-slim

ARG EXTRAS=""
COPY pyproject.toml README.md LICENSE constraints.txt /src/
COPY examples/measured/LICENSE.md /src/examples/measured/LICENSE.md
COPY src /src/src
RUN pip install --no-cache-dir -c /src/constraints.txt "/src${EXTRAS}" \
    && rm -r /src \
    && useradd --create-home --uid 1000 cutwise

USER cutwise
ENV NUMBA_CACHE_DIR=/home/cutwise/.cache/cutwise MPLCONFIGDIR=/home/cutwise/.cache/matplotlib
WORKDIR /work
ENTRYPOINT ["cutwise"]
CMD ["--help"]
